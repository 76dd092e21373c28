"""`mjxwalk doctor`: what this installation has, what it would use, and what it lacks."""

import dataclasses
import importlib.metadata
import platform
import shutil
import sys

import mjxwalk
from mjxwalk import installing


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
        has_gpu, fault = False, None
        try:
            has_gpu = _print_devices()
        except Exception as error:  # a broken installation fails in as many ways as there are
            fault = _fault(error)
            print(fault)
        if shutil.which("nvidia-smi") and not has_gpu:
            missing.append(("the NVIDIA GPU of this machine", installing.of_extra("cuda")))
        for what, command in missing:
            print(f"missing: {what}; add it with: {command}")
        if not missing and fault is None:
            print("nothing is missing")
        is_broken = any(what != "the NVIDIA GPU of this machine" for what, _ in missing)
        return 1 if is_broken or fault is not None else 0


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


def _fault(error: Exception) -> str:
    """Returns in a sentence why JAX does not start."""
    if "jax" in sys.modules:
        from mjxwalk.engines import pinning

        reason = pinning.why_not_started(error)
        if reason is not None:
            return reason
    lines = str(error).strip().splitlines() or ["it says nothing"]
    return f"JAX does not start: {type(error).__name__}, {lines[0]}"


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
            missing.append((name, installing.command(specification.strip())))
            continue
        if exact and version != exact:
            what = f"{name} {exact} (there is {version})"
            missing.append((what, installing.command(specification.strip())))
    return missing
