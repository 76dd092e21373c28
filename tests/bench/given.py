"""Results made up, with ratios that are easily worked out."""

from mjxwalk.bench.results import (
    Evolution,
    Kernel,
    Machine,
    Results,
    Scaling,
    Speed,
)

RESULTS = Results(
    quick=True,
    repeats=3,
    speeds={
        "planar7-points": Speed(
            population=1024,
            steps_per_s={"lanes": 50e6, "mjx": 0.2e6, "mujoco_rollout": 0.5e6},
            ratios={"mjx": 250.0, "mujoco_rollout": 100.0},
            amounts={"lanes": 9000, "mjx": 40, "mujoco_rollout": 100},
            kernel=Kernel(
                operations_per_step=2000,
                share_of_peak=0.4,
                width=16,
                threads=2,
                compile_cold_s=2.5,
                compile_warm_s=0.05,
                code_bytes=40 << 10,
            ),
        )
    },
    evolution=Evolution(
        generations=15,
        population=640,
        lane_utilisation=0.95,
        steps_per_s=45e6,
        peak_steps_per_s=50e6,
    ),
    population_scaling=Scaling(
        ns_per_step={64: 22.0, 1024: 20.0, 65_536: 21.0},
        steps_per_walker={64: 9000, 1024: 5000, 65_536: 1000},
        peak_memory_bytes=700 << 20,
        memory_before_bytes=300 << 20,
    ),
    machine=Machine(
        cpu="a CPU",
        cores=4,
        usable_cores=2,
        load_average=1.5,
        mjx_devices="2 x cpu",
        accelerator=False,
    ),
    versions={"jax": "0.10.2", "llvmlite": None},
)
