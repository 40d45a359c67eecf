"""Says as JSON what a clip holds.

usage: python3 tests/conformance/reader CLIP [--whole-parts]

--whole-parts reads what is whole of a cut or damaged clip.
"""
import json
import pathlib
import sys

from clip import read_clip
from matroska import Damaged
from summary import summary


def main() -> None:
    names = [argument for argument in sys.argv[1:] if argument != "--whole-parts"]
    if len(names) != 1:
        sys.exit(__doc__)
    try:
        clip = read_clip(pathlib.Path(names[0]).read_bytes(), "--whole-parts" in sys.argv)
    except (Damaged, OSError) as error:
        sys.exit(f"{names[0]}: {error}")
    print(json.dumps(summary(clip), indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
