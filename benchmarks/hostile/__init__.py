"""Files that somebody damaged or wrote with ill will, by the thousand: does anything but an answer or an error come?"""
