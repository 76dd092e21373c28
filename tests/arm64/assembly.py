"""What NEON makes of a body's rollout, on a machine of any kind: instructions and spills of a step.

    python tests/arm64/assembly.py --body "h1, points" --cpu neoverse-v1 --out folder

A vector has 4 lanes. With 8, LLVM makes two vectors of each: two in a pass. `--out` keeps the block
that is a step, which `llvm-mca` takes.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm  # untyped

sys.path.insert(0, str(Path(__file__).parents[1]))  # where it runs as a script

from engines.rollouts import BODIES, shapes

from mjxwalk.engines import lanes_ptx
from mjxwalk.engines.lanes.backend.kernel import emit_kernel
from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.envs import TRIAL_AXES

TRIPLE = "aarch64-unknown-linux-gnu"
LANES = 4  # float32 in a vector


class Counted(NamedTuple):
    """The instructions of a step, and those of them that spill or reload."""

    instructions: int
    spills: int
    reloads: int


def assembly(
    lowered: lanes_ptx.Lowered, width: int, cpu: str = "generic", features: str = ""
) -> str:
    """Returns the kernel's assembly, which says where it spills."""
    target = Target(width=width, processor="aarch64", cpu=cpu, features=features, estimates=False)
    text = emit_kernel(lowered.program, lowered.arguments, lowered.results, target).text
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine: Any = llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu=cpu, features=features, opt=2, reloc="pic", codemodel="small"
    )
    machine.set_asm_verbosity(True)
    module: Any = llvm.parse_assembly(text)
    module.triple = TRIPLE
    module.data_layout = str(machine.target_data)
    module.verify()
    options: Any = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.slp_vectorization = options.loop_unrolling = False
    builder: Any = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return str(machine.emit_assembly(module))


def step(code: str) -> list[str]:
    """Returns the lines of the longest block: a step of the rollout."""
    blocks = re.split(r"\n(?=\.LBB\w+:)", code)
    longest = max(blocks, key=lambda block: block.count("\n"))
    return [line for line in longest.splitlines() if re.match(r"\t[a-z]", line)]


def count(lines: Sequence[str]) -> Counted:
    """Returns how many instructions there are."""
    spills, reloads = (
        sum(bool(re.search(rf"-byte (Folded )?{what}", line)) for line in lines)
        for what in ("Spill", "Reload")
    )
    return Counted(len(lines), spills, reloads)


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--body", default="planar7", choices=BODIES)
    parser.add_argument("--cpu", default="neoverse-n1", help="as LLVM calls it")
    parser.add_argument("--features", default="-sve", help="as LLVM calls them, such as +sve")
    parser.add_argument("--out", type=Path, help="folder for the step's assembly")
    asked = parser.parse_args()
    experiment = BODIES[asked.body]()
    arguments = shapes(experiment, LANES)
    lowered = lanes_ptx.lower(experiment.rollout, (0, TRIAL_AXES), *arguments)
    print("| vectors a pass | instructions | spills | reloads | instructions a vector |")
    print("| ---: | ---: | ---: | ---: | ---: |")
    for vectors in (1, 2):
        lines = step(assembly(lowered, LANES * vectors, asked.cpu, asked.features))
        found = count(lines)
        print(f"| {vectors} | " + " | ".join(f"{number:,}" for number in found), end=" | ")
        print(f"{found.instructions / vectors:,.0f} |")
        if asked.out is not None:
            asked.out.mkdir(parents=True, exist_ok=True)
            source = "\n".join([".text", *(line.split("//")[0] for line in lines)])
            (asked.out / f"{vectors}.s").write_text(source + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
