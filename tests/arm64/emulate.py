"""Runs tests of the lanes, or one run twice, on an emulated ARM64; README.md tells how to use it.

    python tests/arm64/emulate.py --folder ~/arm64

Debian's Python and the wheels for ARM64 are unpacked into the folder, where they stay. Nothing of
the system is changed, and no right of its administrator is needed.
"""

import argparse
import filecmp
import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
QEMU = "qemu-aarch64-static"
SOURCE = "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] {} bookworm main"
PACKAGES = ("python3", "libstdc++6", "libgomp1")
TESTERS = ("pytest", "pytest-xdist", "beartype", "hypothesis")
GLIBC = (17, 24, 26, 27, 28, 31, 34)  # minor versions that wheels are made for
DEFAULT = (
    "tests/engines/lanes/test_rollout.py::test_outcomes_do_not_depend_on_threads_batch_or_lane",
    "tests/engines/lanes/runtime/test_mapping.py::test_extremes_pass_nan_on_from_either_side",
    "tests/engines/lanes/runtime/test_mapping.py::test_the_lowest_integer_by_minus_one_does_not_trap",
    "tests/engines/lanes/runtime/test_mapping.py::test_conversion_to_integers_clamps_and_sends_nan_to_zero",
)
# Programs that Python starts are found by this name, and run in the emulator too.
STARTED = "import os, sys\nsys.executable = sys._base_executable = os.environ['ARM64_PYTHON']\n"


def unpack_system(folder: Path, mirror: str) -> None:
    """Unpacks Debian's Python for ARM64 and all that it needs."""
    apt = folder / "apt"
    for name in ("lists/partial", "archives/partial"):
        (apt / name).mkdir(parents=True, exist_ok=True)
    (apt / "status").touch()
    (apt / "sources.list").write_text(SOURCE.format(mirror) + "\n", encoding="utf-8")
    settings = {
        "APT::Architecture": "arm64",
        "APT::Architectures": "arm64",
        "APT::Install-Recommends": "false",
        "Dir::State": str(apt),
        "Dir::State::status": str(apt / "status"),
        "Dir::Cache": str(apt),
        "Dir::Etc::sourcelist": str(apt / "sources.list"),
        "Dir::Etc::sourceparts": "-",
    }
    lines = [f'{name} "{value}";' for name, value in settings.items()]
    (apt / "apt.conf").write_text("\n".join(lines) + "\n", encoding="utf-8")
    environment = os.environ | {"APT_CONFIG": str(apt / "apt.conf")}
    for command in (["update"], ["-y", "install", "--download-only", *PACKAGES]):
        subprocess.run(["apt-get", "-qq", *command], env=environment, check=True)
    for archive in sorted((apt / "archives").glob("*.deb")):
        subprocess.run(["dpkg-deb", "-x", str(archive), str(folder / "root")], check=True)


def unpack_wheels(folder: Path) -> None:
    """Unpacks what mjxwalk and its tests need, as wheels for ARM64."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    platforms = [f"--platform=manylinux_2_{minor}_aarch64" for minor in GLIBC]
    command = [sys.executable, "-m", "pip", "install", "-q", "--target", str(folder / "site")]
    command += ["--python-version=3.11", "--only-binary=:all:", *platforms]
    command += ["--platform=manylinux2014_aarch64", *project["dependencies"], *TESTERS]
    subprocess.run(command, check=True)


def write_starter(folder: Path) -> Path:
    """Writes the program that is Python for ARM64; returns where it is."""
    (folder / "own").mkdir(exist_ok=True)
    (folder / "own/sitecustomize.py").write_text(STARTED, encoding="utf-8")
    starter, root = folder / "python", folder / "root"
    places = ":".join(map(str, (folder / "own", folder / "site", ROOT)))
    starter.write_text(
        f"#!/bin/sh\nexport ARM64_PYTHON={starter} PYTHONPATH={places} PYTHONDONTWRITEBYTECODE=1\n"
        f"export JAX_PLATFORMS=cpu MUJOCO_GL=disable XDG_CACHE_HOME={folder}/cache\n"
        f'exec {QEMU} -L {root} {root}/usr/bin/python3.11 "$@"\n',
        encoding="utf-8",
    )
    starter.chmod(0o755)
    return starter


def run_twice(starter: Path, folder: Path) -> bool:
    """Returns whether two runs of one seed end with the same champion, to the bit."""
    command = [str(starter), "-m", "mjxwalk", "evolve", "--engine", "lanes", "--seed", "7"]
    command += ["--generations", "2", "--population", "64"]
    champions: list[Path] = []
    for name in ("one", "other"):
        out = folder / f"runs-{os.getpid()}" / name
        # A run that ends without a winner has another exit code than 0; its champion is compared.
        subprocess.run([*command, "--out", str(out)], cwd=ROOT, check=False)
        champions.append(out / "champion.npz")
    return all(path.is_file() for path in champions) and filecmp.cmp(*champions, shallow=False)


def main() -> int:
    """Returns 0 where the tests pass, or the two runs have the same bits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, required=True, help="for 1.5 GB that stay there")
    parser.add_argument("--mirror", default="http://deb.debian.org/debian", help="of Debian")
    parser.add_argument("--twice", action="store_true", help="compare two runs in place of tests")
    parser.add_argument("tests", nargs="*", default=DEFAULT, help="for pytest, such as a file")
    asked = parser.parse_args()
    folder = asked.folder.expanduser().resolve()
    if not (folder / "root/usr/bin/python3.11").exists():
        unpack_system(folder, asked.mirror)
    if not (folder / "site").exists():
        unpack_wheels(folder)
    (folder / "cache").mkdir(mode=0o700, exist_ok=True)
    starter = write_starter(folder)
    if asked.twice:
        same = run_twice(starter, folder)
        print(f"two runs of a seed have {'the same' if same else 'DIFFERENT'} bits")
        return 0 if same else 1
    command = [str(starter), "-m", "pytest", "-v", "-n", "0", "-p", "no:cacheprovider"]
    code = subprocess.run([*command, *asked.tests], cwd=ROOT, check=False).returncode
    if code < 0:
        print(f"signal {-code} ended the emulator, and the tests with it", file=sys.stderr)
        return 1
    return code


if __name__ == "__main__":
    sys.exit(main())
