"""The legs of a six-legged platform at the start: each a cross at its foot, a tube, a piston and a ball."""

import math


def legs(request):
    """Of each leg its foot, its ball in the axes of the platform, the two angles of its cross, its length, and the
    stiffness of its spring. The first axis of a cross is x of the ground, the second y of the tube."""
    found = []
    for foot, ball, stiffness in zip(request["feet"], request["balls"], request["stiffness"]):
        way = [ball[0] - foot[0], ball[1] - foot[1], ball[2] + request["height"] - foot[2]]
        length = math.hypot(*way)
        angles = [math.atan2(-way[1], way[2]), math.asin(way[0] / length)]
        found.append((foot, ball, angles, length, stiffness))
    return found
