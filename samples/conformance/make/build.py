#!/usr/bin/env python3
"""Writes all cases of the conformance suite beside this folder, byte for byte the same each time.

usage: python3 samples/conformance/make/build.py [NAME ...]        (Python 3.10 or newer, numpy)
References of the random walk and their means are filled in by `nephrite conformance --update-references`.
"""
import pathlib
import sys

import cases

suite = pathlib.Path(__file__).resolve().parent.parent
wanted = sys.argv[1:]
made = []
for case in cases.everything():
    if not wanted or case.name in wanted:
        case.write(suite)
        made.append(case.name)
missing = set(wanted) - set(made)
if missing:
    sys.exit(f"no such case: {', '.join(sorted(missing))}")
print(f"{len(made)} cases")
