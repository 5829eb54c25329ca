"""What the adapters have in common: the command line that `nephrite conformance --renderer` fills in, and the path of modules.

    import common
    common.leave_path()          # then import the renderer
    args = common.arguments(__doc__)
"""
import argparse
import os
import sys

FOLDER = os.path.dirname(os.path.abspath(__file__))


def leave_path():
    """Takes this folder off the path of modules: adapters are named as the packages that they import, and would hide them."""
    sys.path = [p for p in sys.path if os.path.abspath(p or ".") != FOLDER]


def arguments(text, **more):
    """The command line: `input`, `output`, `width`, `height`, `spp`, `seed`. `text` is the help, `more` the defaults of
    further options, which are strings."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input")
    parser.add_argument("output")
    parser.add_argument("width", type=positive)
    parser.add_argument("height", type=positive)
    parser.add_argument("--spp", type=positive, default=256)
    parser.add_argument("--seed", type=int, default=0)
    for name, default in more.items():
        parser.add_argument(f"--{name}", default=default)
    return parser.parse_args()


def positive(text):
    """A whole number from 1 on."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("must be 1 or more")
    return number
