#!/usr/bin/python3
"""Makes the shipped meshes: binary STL, metres, z up, fronts up and outwards.

    scripts/make_meshes.py                    writes the committed ones into meshes/
    scripts/make_meshes.py --check            compares the committed ones with what it would write
    scripts/make_meshes.py --rolling OUT.stl  writes the large rolling terrain, which is made at build

Same input, same bytes. Needs the standard library only.
"""
import argparse
import math
import os
import struct
import sys

MESH_FOLDER = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "meshes")


# --- STL ---------------------------------------------------------------------------------------------------------------


def single(x):
    """x as the float32 an STL file holds; 0 instead of -0."""
    return struct.unpack("<f", struct.pack("<f", x))[0] + 0.0


def normal(a, b, c):
    u = [b[k] - a[k] for k in range(3)]
    v = [c[k] - a[k] for k in range(3)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if length == 0.0:
        raise ValueError("triangle without area: %s %s %s" % (a, b, c))
    return tuple(x / length + 0.0 for x in n)


def binary_stl(name, triangles):
    # Never "solid" at the start: that would look like a text STL to some readers.
    parts = [("ellipsoid_vehicle_sim " + name).encode("ascii").ljust(80, b" "), struct.pack("<I", len(triangles))]
    facet = struct.Struct("<12fH")
    for triangle in triangles:
        a, b, c = (tuple(single(x) for x in corner) for corner in triangle)
        parts.append(facet.pack(*normal(a, b, c), *a, *b, *c, 0))
    return b"".join(parts)


# --- Sphere and plane --------------------------------------------------------------------------------------------------


def sphere(subdivisions=3):
    """Icosahedron with each triangle cut into four, three times: 1280 triangles, all corners at radius 1."""
    g = (1.0 + math.sqrt(5.0)) / 2.0
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
               (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]

    def onto_sphere(p):
        length = math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        return tuple(x / length for x in p)

    def between(p, q):
        return onto_sphere([p[k] + q[k] for k in range(3)])

    triangles = [tuple(onto_sphere(corners[i]) for i in face) for face in faces]
    for _ in range(subdivisions):
        finer = []
        for a, b, c in triangles:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return triangles


def ground(xs, ys, height):
    """Two triangles to every cell of a grid, z = height(x, y)."""
    z = [[height(x, y) for x in xs] for y in ys]
    triangles = []
    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            a, b = (xs[i], ys[j], z[j][i]), (xs[i + 1], ys[j], z[j][i + 1])
            c, d = (xs[i + 1], ys[j + 1], z[j + 1][i + 1]), (xs[i], ys[j + 1], z[j + 1][i])
            triangles += [(a, b, c), (a, c, d)]
    return triangles


def flat():
    lines = [12.5 * i - 100.0 for i in range(17)]
    return ground(lines, lines, lambda x, y: 0.0)


SLOPE = math.radians(10.0)
# Where the ramp begins, radius of its foot and crest, length between them [m].
FOOT, BEND, BEND_PARTS, SLOPE_LENGTH = 8.0, 80.0, 40, 12.0


def ramp():
    """Level, up at ten degrees, level. Foot and crest are bent so gently that a stiff robot on six wheels keeps its weight
    on the middle ones: half a wheelbase of 0.35 m is lifted by 0.35^2 / 160 m = 0.8 mm."""
    profile = [(-12.0, 0.0), (0.0, 0.0)]
    parts = BEND_PARTS
    profile += [(FOOT + BEND * math.sin(SLOPE * k / parts), BEND * (1.0 - math.cos(SLOPE * k / parts)))
                for k in range(parts + 1)]
    x, z = profile[-1]
    x, z = x + SLOPE_LENGTH * math.cos(SLOPE), z + SLOPE_LENGTH * math.sin(SLOPE)
    top_x, top_z = x + BEND * math.sin(SLOPE), z + BEND * (1.0 - math.cos(SLOPE))
    profile += [(top_x - BEND * math.sin(SLOPE * k / parts), top_z - BEND * (1.0 - math.cos(SLOPE * k / parts)))
                for k in range(parts, -1, -1)]
    profile.append((top_x + 12.0, top_z))
    heights = dict(profile)
    return ground([x for x, _ in profile], [-8.0, 0.0, 8.0], lambda x, y: heights[x])


def rolling(cells=316):
    """199,712 triangles of 1 m, hills of up to 0.5 m."""
    lines = [float(i - cells // 2) for i in range(cells + 1)]

    def height(x, y):
        return (0.25 * math.sin(2.0 * math.pi * (x + 0.3 * y) / 23.0) + 0.15 * math.sin(2.0 * math.pi * (y - 0.2 * x) / 13.0) +
                0.10 * math.sin(2.0 * math.pi * (x - y) / 7.0))

    return ground(lines, lines, height)


# --- Course ------------------------------------------------------------------------------------------------------------
# A quilt: all pieces are cells of one grid of lines, so that neighbours share their corners to the last bit and there is
# no gap and no corner in the middle of an edge, whatever surface they are of. Where two cells are of different height
# along their common side, an upright face of the higher one closes the step. The banked curve alone lies on the quilt.

BUMP_STARTS = (8.0, 12.0, 16.0)
BUMP_LENGTH, BUMP_HEIGHT, BUMP_PARTS = 1.5, 0.075, 10
RAMP = ((48.0, 0.0), (56.5, 1.5), (62.5, 1.5), (71.0, 0.0))  # 10 degrees up and down
STAIRS_UP = [20.0 + 0.5 * k for k in range(6)]               # steps of 0.0625 m
STAIRS_DOWN = [28.0 + 0.5 * k for k in range(5)]             # steps of 0.075 m

COURSE_X = sorted({-10.0, 0.0, 34.0, 38.0, 50.0, 50.25, 80.0, 90.0, 100.0, 110.0, 120.0, 130.0, 140.0, 30.0} |
                  {s + BUMP_LENGTH * k / BUMP_PARTS for s in BUMP_STARTS for k in range(BUMP_PARTS + 1)} |
                  {x for x, _ in RAMP} | set(STAIRS_UP) | set(STAIRS_DOWN))
COURSE_Y = [-30.0, -20.0, -12.25, -12.0, -10.0, -6.0, -4.0, 4.0, 10.0, 16.0, 30.0]


def road_height(x):
    for start in BUMP_STARTS:
        if start < x < start + BUMP_LENGTH:
            return 0.5 * BUMP_HEIGHT * (1.0 - math.cos(2.0 * math.pi * (x - start) / BUMP_LENGTH))
    for (x0, z0), (x1, z1) in zip(RAMP, RAMP[1:]):
        if x0 <= x <= x1:
            return z0 + (z1 - z0) * (x - x0) / (x1 - x0)
    return 0.0


def cell(x, y):
    """(surface, height as a function of x) of the cell with this centre."""
    def level(z):
        return lambda _: z

    if abs(y) < 4.0:
        if 34.0 < x < 38.0:
            return "kerb", level(0.05)
        return ("concrete" if RAMP[0][0] < x < RAMP[-1][0] else "asphalt"), road_height
    if 10.0 < y < 16.0 and STAIRS_UP[0] < x < STAIRS_DOWN[-1]:
        up, down = sum(x > edge for edge in STAIRS_UP), sum(x > edge for edge in STAIRS_DOWN)
        return "concrete", level(0.0625 * up if down == 0 else 0.075 * (5 - down))
    along = 30.0 < x < 50.25 and -12.25 < y < -12.0
    across = 50.0 < x < 50.25 and -12.25 < y < -6.0
    if along or across:
        return "concrete", level(1.5)
    if 62.5 < x < 80.0 and -20.0 < y < -10.0:
        return "kerb", level(0.1)
    return "grass", level(0.0)


def step(meshes, p, q, a, b, heights):
    """Upright face over the edge from p to q (x, y), between surface and heights at p and q of the cells left (a) and right
    (b) of it. `heights` are those of all cells around a point: the sides of the face have corners there, too."""
    high, low = (a, b) if a[1:] > b[1:] else (b, a)
    if high[1:] == low[1:]:
        return
    if low[1] > high[1] or low[2] > high[2]:
        raise ValueError("the heights of two cells cross between %s and %s" % (p, q))
    at_p = [(p[0], p[1], z) for z in heights[p] if low[1] <= z <= high[1]]
    at_q = [(q[0], q[1], z) for z in heights[q] if low[2] <= z <= high[2]]
    # Seen from the right of p -> q, p is on the left: p, q, up is counter-clockwise. The face looks to the lower cell.
    i = j = 0
    while i + 1 < len(at_p) or j + 1 < len(at_q):
        up_at_p = j + 1 == len(at_q) or (i + 1 < len(at_p) and at_p[i + 1][2] <= at_q[j + 1][2])
        triangle = (at_p[i], at_q[j], at_p[i + 1] if up_at_p else at_q[j + 1])
        meshes[high[0]].append(triangle if high is a else (triangle[1], triangle[0], triangle[2]))
        i, j = (i + 1, j) if up_at_p else (i, j + 1)


def quilt(meshes):
    xs, ys = COURSE_X, COURSE_Y
    cells = [[cell(0.5 * (x0 + x1), 0.5 * (y0 + y1)) for x0, x1 in zip(xs, xs[1:])] for y0, y1 in zip(ys, ys[1:])]

    def at(i, j, x0, x1):
        surface, height = cells[j][i]
        return surface, single(height(x0)), single(height(x1))

    heights = {}
    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            surface, z0, z1 = at(i, j, xs[i], xs[i + 1])
            a, b = (xs[i], ys[j], z0), (xs[i + 1], ys[j], z1)
            c, d = (xs[i + 1], ys[j + 1], z1), (xs[i], ys[j + 1], z0)
            meshes[surface] += [(a, b, c), (a, c, d)]
            for x, y, z in (a, b, c, d):
                heights.setdefault((x, y), set()).add(z)
    heights = {point: sorted(zs) for point, zs in heights.items()}

    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            if j + 2 < len(ys):
                x0, x1, y = xs[i], xs[i + 1], ys[j + 1]
                step(meshes, (x0, y), (x1, y), at(i, j + 1, x0, x1), at(i, j, x0, x1), heights)
            if i + 2 < len(xs):
                x = xs[i + 1]
                step(meshes, (x, ys[j]), (x, ys[j + 1]), at(i, j, x, x), at(i + 1, j, x, x), heights)


def bank():
    """A left turn through 90 degrees about (105, 27), 14 degrees steep from radius 12 to 18, falling off outside; it grows
    out of the ground at both ends. All its rim lies on the ground, which goes on below."""
    radii = [12.0, 13.5, 15.0, 16.5, 18.0, 19.25, 20.5]
    profile = [0.0, 0.375, 0.75, 1.125, 1.5, 0.75, 0.0]
    parts = 30

    def growth(k):
        s = min(1.0, min(k, parts - k) / 8.0)
        return s * s * (3.0 - 2.0 * s)

    def corner(k, m):
        angle = -0.5 * math.pi * (1.0 - k / parts)
        return (105.0 + radii[m] * math.cos(angle), 27.0 + radii[m] * math.sin(angle), profile[m] * growth(k))

    triangles = []
    for k in range(parts):
        for m in range(len(radii) - 1):
            a, b, c, d = corner(k, m), corner(k, m + 1), corner(k + 1, m + 1), corner(k + 1, m)
            triangles += [(a, b, c), (a, c, d)]
    return triangles


def course():
    meshes = {"asphalt": [], "concrete": [], "kerb": [], "grass": []}
    quilt(meshes)
    meshes["concrete"] += bank()
    return {"course_" + surface: triangles for surface, triangles in meshes.items()}


# --- Program -----------------------------------------------------------------------------------------------------------


def committed():
    """File name -> bytes."""
    meshes = {"unit_sphere": sphere(), "flat": flat(), "ramp": ramp()}
    meshes.update(course())
    return {name + ".stl": binary_stl(name, triangles) for name, triangles in meshes.items()}


def write(path, content):
    """Whole or not at all: two builds may write it at once."""
    folder = os.path.dirname(os.path.abspath(path))
    os.makedirs(folder, exist_ok=True)
    unfinished = "%s.%d" % (path, os.getpid())
    with open(unfinished, "wb") as file:
        file.write(content)
    os.replace(unfinished, path)


def check():
    wrong = []
    for name, content in sorted(committed().items()):
        path = os.path.join(MESH_FOLDER, name)
        if not os.path.isfile(path):
            wrong.append("meshes/%s is missing" % name)
            continue
        with open(path, "rb") as file:
            if file.read() != content:
                wrong.append("meshes/%s is not what scripts/make_meshes.py makes" % name)
    return wrong


def main():
    parser = argparse.ArgumentParser(description="Makes the shipped meshes.")
    parser.add_argument("--rolling", metavar="OUT.stl", help="write the rolling terrain there, and nothing else")
    parser.add_argument("--check", action="store_true", help="only compare the committed meshes; exit code 1 if they differ")
    arguments = parser.parse_args()
    if arguments.rolling:
        write(arguments.rolling, binary_stl("rolling", rolling()))
        return 0
    if arguments.check:
        wrong = check()
        for line in wrong:
            print(line, file=sys.stderr)
        return 1 if wrong else 0
    for name, content in sorted(committed().items()):
        write(os.path.join(MESH_FOLDER, name), content)
    return 0


if __name__ == "__main__":
    sys.exit(main())
