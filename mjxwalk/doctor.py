"""`mjxwalk doctor`: what this installation has, what it would use, and what it lacks."""

import dataclasses
import importlib.metadata
import platform
import shutil

import mjxwalk


@dataclasses.dataclass(frozen=True, kw_only=True)
class Doctor:
    """Show versions, devices and the engine that auto takes, and what is missing."""

    def run(self) -> int:
        """Prints what it finds; returns 0 if everything that is needed is there, else 1."""
        from mjxwalk.runs import manifest

        print(f"mjxwalk {mjxwalk.__version__}, Python {platform.python_version()}")
        for package, version in manifest.versions().items():
            print(f"  {package:17} {version or 'missing'}")
        print(f"cpu      {manifest.cpu_model()}")
        missing = _missing()
        has_gpu = False
        try:
            has_gpu = _print_devices()
        except Exception as error:  # a broken installation fails in as many ways as there are
            print(f"JAX does not start: {error}")
            missing.append(("JAX", _command("jax")))
        if shutil.which("nvidia-smi") and not has_gpu:
            missing.append(("the NVIDIA GPU of this machine", _command("jax", extra="cuda")))
        for what, command in missing:
            print(f"missing: {what}; add it with: {command}")
        if not missing:
            print("nothing is missing")
        return 1 if any(what != "the NVIDIA GPU of this machine" for what, _ in missing) else 0


def _print_devices() -> bool:
    """Prints what JAX sees and what auto takes; returns whether there is an accelerator."""
    import jax

    from mjxwalk import engines

    engines.prepare()
    devices = jax.devices()
    print(f"devices  {len(devices)} x {devices[0].device_kind} ({devices[0].platform})")
    choice = engines.choose("auto")
    print(f"engine   auto is {choice.name}: {choice.why}")
    return devices[0].platform != "cpu"


def _missing() -> list[tuple[str, str]]:
    """Returns the needed packages that are absent or of another version, with their cure."""
    wanted = importlib.metadata.requires("mjxwalk") or []
    missing: list[tuple[str, str]] = []
    for line in wanted:
        specification, _, marker = line.partition(";")
        if "extra" in marker:
            continue
        name = specification.split("[")[0]
        for sign in "=><!~ ":
            name = name.split(sign)[0]
        exact = specification.strip().partition("==")[2]
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            missing.append((name, f'python -m pip install "{specification.strip()}"'))
            continue
        if exact and version != exact:
            what = f"{name} {exact} (there is {version})"
            missing.append((what, f'python -m pip install "{specification.strip()}"'))
    return missing


def _command(package: str, extra: str = "") -> str:
    """Returns what installs a package as mjxwalk asks for it, in an extra or by itself."""
    for line in importlib.metadata.requires("mjxwalk") or []:
        specification, _, marker = line.partition(";")
        if specification.startswith(package) and (f'"{extra}"' in marker if extra else not marker):
            return f'python -m pip install "{specification.strip()}"'
    return f'python -m pip install "{package}"'
