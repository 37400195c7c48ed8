"""A control loop on a map: python examples/loop.py models/half-cheetah-exact-vibration [SECONDS]."""

import sys

from gaitflow.runtime import GaitMap, NoTransition

RATE = 50  # Hz
SPEEDS = (0.4, 0.45, 0.9, 1.5, 1.5, 0.7)  # m/s, a new one each second


def main(folder: str, seconds: int = len(SPEEDS)) -> None:
    """Follow the map's motions while the speed that is asked for changes."""
    gait_map = GaitMap.load(folder)
    choice = gait_map.select(speed=SPEEDS[0])
    motion = gait_map.plan(**choice.task, gait=choice.gait).motion()
    for tick in range(seconds * RATE):  # a robot's loop waits here for its clock
        now = tick / RATE
        if tick % RATE == 0:
            asked = gait_map.select(speed=SPEEDS[tick // RATE % len(SPEEDS)], previous=choice)
            plan = gait_map.plan(**asked.task, gait=asked.gait)  # ... and plans in another thread
            if plan.feasible and asked != choice:
                try:
                    motion = gait_map.switch(motion, plan.motion(), after=now)
                    choice = asked
                except NoTransition as error:
                    print(f"{now:5.2f} s  goes on as before: {error}")
        state = motion.at(now)  # feet, forces and the body, for a controller of yours
        if tick % RATE == 0:
            stands = " ".join("|" if down else "-" for down in state.contact)
            print(f"{now:5.2f} s  {choice.speed:.1f} m/s  {choice.gait:12}  {stands}  x = {state.position[0]:.2f} m")
    print(f"followed for {seconds} s: {motion.at(float(seconds)).velocity[0]:.2f} m/s at the end")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
