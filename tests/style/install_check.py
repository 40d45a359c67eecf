#!/usr/bin/env python3
"""Checks that an installation holds the tool, its modules, the player's library, the public headers and what finds them, and nothing else, and that it runs.

usage: install_check.py ROOT BUILD
"""
import pathlib
import subprocess
import sys
import tempfile


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    headers = pathlib.Path(sys.argv[1]) / "include"
    modules = pathlib.Path(sys.argv[2]) / "lib/kinora"
    expected = {"bin/kinora"} | {f"lib/kinora/{p.name}" for p in modules.glob("*.so")}
    expected |= {f"include/{p.relative_to(headers).as_posix()}" for p in headers.rglob("*.h*")}
    expected |= {f"lib/{p.name}" for p in modules.parent.glob("libkinora_player.so*")}
    names = ("KinoraConfig", "KinoraConfigVersion", "kinora-player", "kinora-player-release", "kinora-plugin")
    expected |= {f"lib/cmake/Kinora/{name}.cmake" for name in names}
    expected |= {f"lib/pkgconfig/kinora-{component}.pc" for component in ("player", "plugin")}
    page = pathlib.Path(sys.argv[1]) / "build/page"  # there if web/build has been run
    expected |= {f"share/kinora/page/{p.name}" for p in page.glob("*")}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["cmake", "--install", sys.argv[2], "--prefix", folder], check=True, stdout=subprocess.DEVNULL)
        prefix = pathlib.Path(folder)
        found = {p.relative_to(prefix).as_posix() for p in prefix.rglob("*") if not p.is_dir()}
        for name in sorted(found - expected):
            print(f"installed, but not public: {name}")
        for name in sorted(expected - found):
            print(f"public, but not installed: {name}")
        if found != expected:
            sys.exit(1)
        said = subprocess.run([str(prefix / "bin/kinora"), "formats"], check=True, capture_output=True, text=True).stdout
        for module in modules.glob("*.so"):
            if f"{module.name} is not installed" in said:
                sys.exit(f"the installed program does not find {module.name}")


if __name__ == "__main__":
    main()
