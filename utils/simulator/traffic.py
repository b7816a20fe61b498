"""Objects of a street, composed of simple solids.

Every function returns an `Obstacle` at the origin, heading along x, whose solids fit its true
box. `dataclasses.replace(obstacle, pose=..., speed=...)` gives it a place and a speed.
"""

from __future__ import annotations

from utils.simulator.shapes import Material, Solid, box, cylinder, sphere
from utils.simulator.world import Obstacle

PAINT = Material(reflectivity=0.48, loss=0.02)
GLASS = Material(reflectivity=0.24, loss=0.20)
RUBBER = Material(reflectivity=0.08)
CLOTH = Material(reflectivity=0.35)
SKIN = Material(reflectivity=0.45)
STEEL = Material(reflectivity=0.35)
MATT = Material(reflectivity=0.02, loss=1.0)
FOIL = Material(reflectivity=0.99)
PLASTER = Material(reflectivity=0.46, loss=0.01)
WINDOW = Material(reflectivity=0.18, loss=0.30)
BARK = Material(reflectivity=0.25)
LEAVES = Material(reflectivity=0.40, depth=0.45)
HEDGE = Material(reflectivity=0.40, depth=0.10)


def car(length: float = 4.3, width: float = 1.75, height: float = 1.5) -> Obstacle:
    """Build a passenger car: body, cabin of mostly glass, four wheels and foil number plates."""
    floor, waist = 0.24, 0.58 * height
    cabin = 0.66 * length
    wheel = 0.62
    solids = [
        box(length, width, waist - floor, (0, 0, (waist + floor) / 2), PAINT, (0.12, 0.06, 0.03)),
        box(
            cabin,
            width - 0.12,
            height - waist,
            (-0.06 * length, 0, (waist + height) / 2),
            GLASS,
            (0.75, 0.45, 0.16),
        ),
        box(0.3 * length, width - 0.46, 0.03, (-0.06 * length, 0, height - 0.015), PAINT),
    ]
    for x in (0.31 * length, -0.31 * length):
        for y in (width / 2 - 0.12, 0.12 - width / 2):
            solids.append(box(wheel, 0.2, wheel, (x, y, wheel / 2), RUBBER))
    for x in (length / 2 - 0.05, 0.05 - length / 2):
        solids.append(box(0.1, 0.5, 0.12, (x, 0, floor + 0.15), FOIL))
    return Obstacle("car", (length, width, height), tuple(solids))


def block_car(length: float = 4.0, width: float = 2.0, height: float = 2.0) -> Obstacle:
    """Build a car of the simple highway: its upper third has half the length."""
    opaque = Material(PAINT.reflectivity)
    lower = box(length, width, height * 2 / 3, (0, 0, height / 3), opaque)
    upper = box(length / 2, width, height / 3, (0, 0, height * 5 / 6), opaque)
    return Obstacle("car", (length, width, height), (lower, upper))


def truck(length: float = 7.5, width: float = 2.3, height: float = 3.1) -> Obstacle:
    """Build a delivery lorry with a cab in front, a load behind and wheels below."""
    floor, cab = 0.6, 1.9
    load = length - cab - 0.2
    solids = [
        box(load, width, height - floor, ((load - length) / 2, 0, (height + floor) / 2), PAINT),
        box(
            cab,
            width - 0.1,
            0.8 * height - 0.4,
            ((length - cab) / 2, 0, (0.8 * height + 0.4) / 2),
            PAINT,
            (0.35, 0.0, 0.05),
        ),
    ]
    for x in (0.36 * length, -0.3 * length):
        for y in (width / 2 - 0.16, 0.16 - width / 2):
            solids.append(box(0.85, 0.28, 0.85, (x, y, 0.425), RUBBER))
    return Obstacle("truck", (length, width, height), tuple(solids))


def pedestrian(height: float = 1.75, stride: float = 0.25) -> Obstacle:
    """Build a pedestrian: legs half a `stride` (metres) ahead and behind, trunk, arms and head."""
    hip, shoulder = 0.48 * height, 0.82 * height
    solids = (
        cylinder(0.08, hip, (stride / 2, 0.1, 0), CLOTH),
        cylinder(0.08, hip, (-stride / 2, -0.1, 0), CLOTH),
        box(0.24, 0.40, shoulder - hip, (0, 0, (hip + shoulder) / 2), CLOTH),
        cylinder(0.05, shoulder - hip, (-stride / 3, 0.25, hip), CLOTH),
        cylinder(0.05, shoulder - hip, (stride / 3, -0.25, hip), CLOTH),
        sphere(0.12, (0, 0, height - 0.12), SKIN),
    )
    return Obstacle("pedestrian", (0.6, 0.6, height), solids)


def cyclist(length: float = 1.75, height: float = 1.75) -> Obstacle:
    """Build a bicycle and its rider."""
    wheel, axle = 0.66, length / 2 - 0.33
    solids = (
        box(wheel, 0.05, wheel, (axle, 0, wheel / 2), RUBBER),
        box(wheel, 0.05, wheel, (-axle, 0, wheel / 2), RUBBER),
        box(1.0, 0.05, 0.30, (0, 0, 0.62), STEEL),
        box(0.06, 0.56, 0.06, (0.42, 0, 1.02), STEEL),
        cylinder(0.08, 0.75, (0.05, 0.14, 0.25), CLOTH),
        cylinder(0.08, 0.75, (-0.12, -0.14, 0.30), CLOTH),
        box(0.50, 0.38, 0.55, (0.0, 0, 1.22), CLOTH, (0.0, 0.25, 0.04)),
        sphere(0.13, (0.18, 0, height - 0.13), SKIN),
    )
    return Obstacle("cyclist", (length, 0.6, height), solids)


def pole(height: float = 5.0, radius: float = 0.07, sign: bool = False) -> Obstacle:
    """Build a lamp post, or a post with a traffic sign that faces along x in both directions."""
    solids: list[Solid] = [cylinder(radius, height, material=STEEL)]
    width = 2 * radius
    if sign:
        width = 0.6
        solids.append(box(2 * radius, width, 0.6, (0, 0, height - 0.35), FOIL))
    return Obstacle("pole", (2 * radius, width, height), tuple(solids))


def tree(height: float = 6.0, crown: float = 1.8, trunk: float = 0.16) -> Obstacle:
    """Build a street tree: a trunk and a crown of five balls, `crown` metres in radius."""
    ball = 0.62 * crown
    ring = crown - ball
    middle = height - crown
    solids: list[Solid] = [cylinder(trunk, middle, material=BARK)]
    for x, y, z in ((1, 0, -0.4), (-1, 0, -0.2), (0, 1, -0.1), (0, -1, -0.3), (0, 0, 1)):
        solids.append(sphere(ball, (x * ring, y * ring, middle + z * ring), LEAVES))
    return Obstacle("foliage", (2 * crown, 2 * crown, height), tuple(solids))


def hedge(length: float = 4.0, width: float = 0.7, height: float = 1.2) -> Obstacle:
    """Build a clipped hedge along x."""
    solid = box(length, width, height + 0.3, (0, 0, (height - 0.3) / 2), HEDGE)
    return Obstacle("foliage", (length, width, height), (solid,))


def house(length: float = 10.0, depth: float = 8.0, height: float = 7.0) -> Obstacle:
    """Build a house whose front, with windows at street level, faces negative y."""
    # The foundation reaches below the street, so that there is no gap on a slope.
    solids = [box(length, depth, height + 1.0, (0, 0, (height - 1.0) / 2), PLASTER)]
    panes = max(1, int(length // 3.0))
    for index in range(panes):
        x = (index + 0.5 - panes / 2) * length / panes
        solids.append(box(1.3, 0.04, 1.4, (x, -depth / 2, 1.7), WINDOW))
    return Obstacle("wall", (length, depth, height), tuple(solids))


def garden_wall(length: float = 6.0, height: float = 1.4) -> Obstacle:
    """Build a low wall along x."""
    solid = box(length, 0.25, height + 0.5, (0, 0, (height - 0.5) / 2), PLASTER)
    return Obstacle("wall", (length, 0.25, height), (solid,))


def ego_roof(height: float = 1.73) -> tuple[Solid, ...]:
    """Build the parts of the ego car that are in the lowest beams of a sensor at `height` metres.

    Parts that return an echo are in the box (-1.5, -1.7, -1.0) to (2.6, 1.7, -0.4) in sensor
    coordinates. Matt parts return no echo but cast shadows on the road, in about the same places
    as KITTI's car: straight behind, ahead, and next to its racks.
    """
    tailgate = box(0.2, 0.30, 0.1, (-1.35, 0.45, height - 0.69), PAINT)
    aerial = cylinder(0.012, 0.25, (-1.25, -0.50, height - 0.74), STEEL)
    mirrors = (box(0.1, 0.14, 0.16, (0.95, y, height - 0.70), PAINT) for y in (1.0, -1.0))
    shadows = (
        box(0.1, 0.50, 0.3, (-1.15, 0.0, height - 0.53), MATT),
        box(0.1, 0.22, 0.3, (0.80, 0.03, height - 0.45), MATT),
        box(0.1, 0.10, 0.3, (0.22, -0.50, height - 0.32), MATT),
        box(0.1, 0.10, 0.3, (-0.32, -0.50, height - 0.36), MATT),
    )
    return (tailgate, aerial, *mirrors, *shadows)
