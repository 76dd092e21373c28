"""The CUDA driver's calls, with a driver that is made up: it has the CPU's memory and its code."""

import ctypes
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engines.lanes import cpu_threads
from engines.lanes.cases import GROUND, STARTS, stroll

from mjxwalk.engines import cuda_driver, lanes_ptx
from mjxwalk.engines.lanes.backend import ptx

STROLL_AXES: Any = (0, None, 0, None)


def write(reference: Any, value: Any) -> None:
    """Writes to where a `byref` points."""
    reference._obj.value = value


class Driver:
    """A GPU that is the CPU: addresses are the host's, and a launch runs `loaded`.

    It takes the arguments as the C functions do, in their types, and counts what is not given back.
    """

    def __init__(self, loaded: Any = None, arrays: int = 0, failing: str = "") -> None:
        self.loaded, self.arrays, self.failing = loaded, arrays, failing
        self.memory: dict[int, Any] = {}
        self.launches: list[tuple[int, ...]] = []
        self.source = b""

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("cu"):
            raise AttributeError(name)
        own = getattr(self, f"on_{name}", lambda *args: None)

        def called(*args: Any) -> int:
            if name == self.failing:
                return 100
            own(*args)
            return 0

        return called

    def on_cuGetErrorString(self, code: Any, text: Any) -> None:
        write(text, b"no CUDA-capable device is detected" if code.value == 100 else b"?")

    def on_cuDevicePrimaryCtxRetain(self, context: Any, device: Any) -> None:
        write(context, 77)

    def on_cuCtxSetCurrent(self, context: Any) -> None:
        assert context.value == 77

    def on_cuDeviceGetName(self, name: Any, length: Any, device: Any) -> None:
        name.value = b"A CPU"

    def on_cuDeviceGetAttribute(self, found: Any, number: Any, device: Any) -> None:
        write(found, {75: 9, 76: 0, 16: 4}[number.value])

    def on_cuModuleLoadDataEx(
        self, module: Any, image: Any, count: Any, options: Any, values: Any
    ) -> None:
        assert count.value == len(options) == len(values) == 2
        assert list(options) == [5, 6] and values[1] == 8_192
        self.source = image.value
        write(module, 5)

    def on_cuModuleGetFunction(self, function: Any, module: Any, name: Any) -> None:
        assert module.value == 5 and name.value == ptx.ENTRY.encode()
        write(function, 6)

    def on_cuFuncGetAttribute(self, found: Any, number: Any, function: Any) -> None:
        write(found, {4: 40, 3: 0}[number.value])

    def on_cuMemAlloc_v2(self, place: Any, size: Any) -> None:
        assert size.value > 0  # the driver refuses no memory
        piece = ctypes.create_string_buffer(size.value)
        self.memory[ctypes.addressof(piece)] = piece
        write(place, ctypes.addressof(piece))

    def on_cuMemFree_v2(self, place: Any) -> None:
        del self.memory[place.value]

    def on_cuMemcpyHtoD_v2(self, place: Any, source: Any, size: Any) -> None:
        assert size.value <= len(self.memory[place.value])
        ctypes.memmove(place.value, source, size.value)

    def on_cuMemcpyDtoH_v2(self, destination: Any, place: Any, size: Any) -> None:
        assert size.value <= len(self.memory[place.value])
        ctypes.memmove(destination, place.value, size.value)

    def on_cuLaunchKernel(self, function: Any, *args: Any) -> None:
        *sizes, shared, stream, parameters, extra = args
        assert function.value == 6 and shared.value == 0 and stream is None and extra is None
        self.launches.append(tuple(size.value for size in sizes))
        *places, count = [
            ctypes.cast(parameter, ctypes.POINTER(ctypes.c_int64))[0] for parameter in parameters
        ]
        assert set(places) <= set(self.memory)
        inputs = np.array(places[: self.arrays] or [0], np.uint64)
        outputs = np.array(places[self.arrays :], np.uint64)
        none, spent = np.zeros(1, np.int64), np.zeros(2, np.int64)
        self.loaded.call(inputs.ctypes.data, outputs.ctypes.data, none.ctypes.data, count,
                         none.ctypes.data, none.ctypes.data, spent.ctypes.data)  # fmt: skip


def test_walkers_go_to_the_gpu_and_come_back() -> None:
    args = (STARTS, GROUND, (np.arange(203) % 3).astype(np.int32), np.int32(300))
    lowered = lanes_ptx.lower(stroll, STROLL_AXES, *args)
    driver = Driver(cpu_threads.load(lowered), arrays=len(args))
    mapped = lanes_ptx.vmap(stroll, STROLL_AXES, device=cuda_driver.Device(driver))
    ours, theirs = mapped(*args), cpu_threads.vmap(stroll, STROLL_AXES)(*args)
    for first, second in zip(jax.tree.leaves(ours), jax.tree.leaves(theirs), strict=True):
        np.testing.assert_array_equal(first, second)
    assert driver.launches == [(-(-203 // ptx.THREADS), 1, 1, ptx.THREADS, 1, 1)]
    assert driver.memory == {}
    assert driver.source.decode() == lowered.ptx()
    assert mapped.kernel is not None and mapped.kernel.registers == 40


def test_a_kernel_is_compiled_once_for_each_set_of_shapes() -> None:
    def twice(x: Any) -> Any:
        return x * 2

    driver = Driver(cpu_threads.load(lanes_ptx.lower(twice, 0, STARTS)), arrays=1)
    mapped = lanes_ptx.vmap(twice, device=cuda_driver.Device(driver))
    np.testing.assert_array_equal(mapped(STARTS[:5]), STARTS[:5] * 2)
    driver.failing = "cuModuleLoadDataEx"
    np.testing.assert_array_equal(mapped(STARTS), STARTS * 2)
    with pytest.raises(cuda_driver.CudaError):
        mapped(jnp.stack([STARTS, STARTS], 1))


def test_no_walkers_are_no_launch() -> None:
    driver = Driver()
    mapped = lanes_ptx.vmap(lambda x: x * 2, device=cuda_driver.Device(driver))
    assert mapped(STARTS[:0]).shape == (0,) and driver.launches == []


def test_an_error_of_the_driver_is_a_sentence_and_gives_memory_back() -> None:
    with pytest.raises(cuda_driver.CudaError, match=r"cuInit .* no CUDA-capable device .*100"):
        cuda_driver.Device(Driver(failing="cuInit"))
    driver = Driver(failing="cuLaunchKernel")
    mapped = lanes_ptx.vmap(lambda x: x * 2, device=cuda_driver.Device(driver))
    with pytest.raises(cuda_driver.CudaError, match="cuLaunchKernel"):
        mapped(STARTS)
    assert driver.memory == {}


def test_no_driver_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cuda_driver, "LIBRARY", "libnowhere.so.1")
    with pytest.raises(cuda_driver.CudaError, match="there is no NVIDIA driver here: libnowhere"):
        lanes_ptx.vmap(lambda x: x * 2)
