"""The files that belong to the repository."""
import pathlib
import subprocess
import sys


def tracked_files(root):
    """Names below the root of all files that git tracks and that are there."""
    # The checkout may belong to another user than the one who runs the tests.
    command = ["git", "-c", "safe.directory=*", "-C", str(root), "ls-files", "-z"]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{root} is no git checkout: {result.stderr.strip()}")
    names = [name for name in result.stdout.split("\0") if name]
    return [name for name in names if (pathlib.Path(root) / name).is_file()]
