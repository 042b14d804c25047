#!/usr/bin/env python3
"""Compares every #include of the source with the rooms' include table.

The table is what each room's CMakeLists.txt says after MAY_INCLUDE in its gvx_room() call. Everybody may use core and
exec. Prints each wrong include and exits with 1, or says how many were right. With --lone-headers it lists the
headers that no source of their own includes first, from src on.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROOMS = ROOT / "src" / "gvx"
# What is above the rooms, and which rooms it may include.
ABOVE = {"apps": {"open", "engine", "mesh", "produce", "render", "scene", "io", "store", "surface"},
         "python": {"open", "engine", "scene", "io"},
         "examples": {"open", "engine", "mesh", "produce", "render", "scene", "io", "store"}, "tests": None, "bench": None}
KEYWORDS = {"SOURCES", "DEVICE_SOURCES", "TESTS", "DEVICE_TESTS", "LIBRARIES"}


def include_table():
    table = {}
    for listing in sorted(ROOMS.glob("*/CMakeLists.txt")):
        words = re.search(r"gvx_room\(([^)]*)\)", listing.read_text()).group(1).split()
        name, rest = words[0], words[words.index("MAY_INCLUDE") + 1:]
        if name != listing.parent.name:
            sys.exit(f"{listing}: the room is called {name}, its folder {listing.parent.name}")
        allowed = set()
        for word in rest:
            if word in KEYWORDS:
                break
            allowed.add(word)
        table[name] = allowed | {name, "core"} | ({"exec"} if name != "core" else set())
    return table


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        found = re.match(r'\s*#\s*include\s*"gvx/(\w+)/', line)
        if found:
            yield number, found.group(1)


def lone_headers():
    """Headers that no source of their own name includes first: nothing else shows that they compile alone."""
    for path in sorted(ROOMS.rglob("*.h")):
        own = [path.with_name(path.stem + ending) for ending in (".cpp", "_test.cpp")]
        name = f'"{path.relative_to(ROOT / "src")}"'
        firsts = (re.search(r"#\s*include\s*(\S+)", source.read_text()) for source in own if source.exists())
        if not any(first and first.group(1) == name for first in firsts):
            yield str(path.relative_to(ROOT / "src"))


def main():
    if sys.argv[1:] == ["--lone-headers"]:
        print("\n".join(lone_headers()))
        return 0
    table = include_table()
    wrong, right = [], 0
    for room, allowed in table.items():
        for path in sorted((ROOMS / room).rglob("*")):
            if path.suffix not in {".h", ".cpp", ".inc"}:
                continue
            for number, target in includes(path):
                if target in allowed:
                    right += 1
                else:
                    wrong.append(f"{path.relative_to(ROOT)}:{number}: {room} may not include {target}")
    for folder, allowed in ABOVE.items():
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp", ".inc"}:
                continue
            for number, target in includes(path):
                if allowed is None or target in allowed | {"core", "exec"}:
                    right += 1
                else:
                    wrong.append(f"{path.relative_to(ROOT)}:{number}: {folder} may not include {target}")
    # The table itself must have no circle: a room and what it includes come in an order.
    order, left = [], {room: allowed - {room} for room, allowed in table.items()}
    while left:
        ready = [room for room, needs in left.items() if not needs - set(order)]
        if not ready:
            wrong.append(f"the include table goes in a circle: {', '.join(sorted(left))}")
            break
        order += ready
        left = {room: needs for room, needs in left.items() if room not in ready}
    print("\n".join(wrong) if wrong else f"check_includes: {right} includes follow the table")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
