"""Files of tables: the columns of solutions, where they come from, and a seal over every byte."""
