"""Turns a function that JAX can trace into an ONNX graph.

Ours, since the library for it, jax2onnx, holds Orbax back to a version that cannot read our runs.
Only what controllers are made of is known: elementwise arithmetic and logic, choices, products of
matrices, sums, and moving parts of arrays around. What depends on constants alone is computed here.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import numpy as np

from mjxwalk import installing
from mjxwalk.errors import RunError

OPSET = 17  # ours: of 2022, which runtimes on robots have by now

# Primitives of JAX whose operator takes the same operands.
PLAIN = {
    "add": "Add",
    "sub": "Sub",
    "mul": "Mul",
    "div": "Div",
    "max": "Max",
    "min": "Min",
    "pow": "Pow",
    "neg": "Neg",
    "abs": "Abs",
    "exp": "Exp",
    "log": "Log",
    "logistic": "Sigmoid",
    "sin": "Sin",
    "cos": "Cos",
    "tanh": "Tanh",
    "sqrt": "Sqrt",
    "sign": "Sign",
    "and": "And",
    "or": "Or",
    "not": "Not",
    "xor": "Xor",
    "lt": "Less",
    "gt": "Greater",
    "le": "LessOrEqual",
    "ge": "GreaterOrEqual",
    "eq": "Equal",
    "copy": "Identity",
    "stop_gradient": "Identity",
}
INLINE = ("jit", "pjit", "closed_call", "custom_jvp_call")


def to_onnx(step: Callable[..., Mapping[str, Any]], inputs: Mapping[str, Any]) -> bytes:
    """Returns an ONNX model of a function.

    Args:
      step: takes the inputs by name, and returns outputs by name.
      inputs: `jax.ShapeDtypeStruct` by name.

    Raises:
      RunError: onnx is not installed, or the function holds an operation that is not known here.
    """
    onnx = installing.load("onnx", "onnx", "ONNX")
    names = list(inputs)
    outputs: list[str] = []
    closed = _traced(step, inputs, outputs)
    graph = _Graph(onnx)
    known = dict(zip(closed.jaxpr.constvars, map(np.asarray, closed.consts), strict=True))
    known |= dict(zip(closed.jaxpr.invars, names, strict=True))
    returned = graph.run(closed.jaxpr, known)
    for name, value in zip(outputs, returned, strict=True):
        graph.node("Identity", [value], name=name)
    graph.keep_what_leads_to(outputs)
    shapes = [var.aval for var in closed.jaxpr.outvars]
    model = onnx.helper.make_model(
        onnx.helper.make_graph(
            graph.nodes,
            "controller",
            [graph.described(name, inputs[name]) for name in names],
            [graph.described(name, aval) for name, aval in zip(outputs, shapes, strict=True)],
            graph.constants,
        ),
        opset_imports=[onnx.helper.make_opsetid("", OPSET)],
        producer_name="mjxwalk",
    )
    model.ir_version = 8  # the one of this operator set; newer ones are refused by older runtimes
    onnx.checker.check_model(model, full_check=True)
    return model.SerializeToString()


def reads(step: Callable[..., Mapping[str, Any]], inputs: Mapping[str, Any]) -> dict[str, set[str]]:
    """Returns the names of the inputs that each output of a function depends on.

    Args:
      step: as `to_onnx` takes it.
      inputs: shapes and types by name.
    """
    outputs: list[str] = []
    closed = _traced(step, inputs, outputs)
    found = _sources(closed.jaxpr, [{name} for name in inputs])
    return dict(zip(outputs, found, strict=True))


def _traced(
    step: Callable[..., Mapping[str, Any]], inputs: Mapping[str, Any], outputs: list[str]
) -> Any:
    """Returns the jaxpr of a function, and fills in the names of its outputs."""
    names = list(inputs)

    def flat(*values: Any) -> list[Any]:
        returned = step(**dict(zip(names, values, strict=True)))
        # What it returns in dicts would come back sorted by name.
        outputs[:] = list(returned)
        return list(returned.values())

    return jax.make_jaxpr(flat)(*inputs.values())


def _sources(jaxpr: Any, given: list[set[str]]) -> list[set[str]]:
    """Returns what each result of a jaxpr depends on, given what its arguments do."""
    known: dict[Any, set[str]] = dict(zip(jaxpr.invars, given, strict=True))

    def of(atom: Any) -> set[str]:
        return set() if hasattr(atom, "val") else known.get(atom, set())

    for equation in jaxpr.eqns:
        operands = [of(atom) for atom in equation.invars]
        inner = equation.params.get("jaxpr", equation.params.get("call_jaxpr"))
        if equation.primitive.name in INLINE and inner is not None:
            results = _sources(getattr(inner, "jaxpr", inner), operands)
        else:
            results = [set[str]().union(*operands)] * len(equation.outvars)
        known |= dict(zip(equation.outvars, results, strict=True))
    return [of(atom) for atom in jaxpr.outvars]


class _Graph:
    """Nodes so far. A value is a numpy array if it is known, else the name of what computes it."""

    def __init__(self, onnx: Any) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []
        self._onnx = onnx

    def described(self, name: str, like: Any) -> Any:
        """Returns the description of an input or output."""
        kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(like.dtype))
        return self._onnx.helper.make_tensor_value_info(name, kind, list(like.shape))

    def node(
        self, operator: str, operands: Sequence[Any], name: str | None = None, **options: Any
    ) -> str:
        """Adds a node and returns the name of its result."""
        name = name or f"v{len(self.nodes)}"
        operands = [self._named(operand) for operand in operands]
        self.nodes.append(self._onnx.helper.make_node(operator, operands, [name], **options))
        return name

    def keep_what_leads_to(self, names: Sequence[str]) -> None:
        """Leaves out nodes and constants on which none of these values depends."""
        needed, kept = set(names), list[Any]()
        for node in reversed(self.nodes):
            if needed.intersection(node.output):
                kept.append(node)
                needed.update(node.input)
        self.nodes = kept[::-1]
        self.constants = [each for each in self.constants if each.name in needed]

    def run(self, jaxpr: Any, known: dict[Any, Any]) -> list[Any]:
        """Returns the values of a jaxpr's results."""

        def read(atom: Any) -> Any:
            return np.asarray(atom.val) if hasattr(atom, "val") else known[atom]

        for equation in jaxpr.eqns:
            operands = [read(atom) for atom in equation.invars]
            results = self._apply(equation, operands)
            known |= dict(zip(equation.outvars, results, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def _named(self, value: Any) -> str:
        if isinstance(value, str):
            return value
        name = f"c{len(self.constants)}"
        self.constants.append(self._onnx.numpy_helper.from_array(np.asarray(value), name))
        return name

    def _apply(self, equation: Any, operands: list[Any]) -> list[Any]:
        primitive, params = equation.primitive.name, equation.params
        inner = params.get("jaxpr", params.get("call_jaxpr"))
        if primitive in INLINE and inner is not None:
            body = getattr(inner, "jaxpr", inner)
            values = dict(zip(body.invars, operands, strict=True))
            consts = map(np.asarray, getattr(inner, "consts", ()))
            return self.run(body, values | dict(zip(body.constvars, consts, strict=True)))
        if not any(isinstance(operand, str) for operand in operands):
            results: Any = equation.primitive.bind(*operands, **params)
            several = equation.primitive.multiple_results
            return [np.asarray(each) for each in (results if several else [results])]
        if primitive == "unstack":
            return self._unstacked(equation, operands[0])
        return [self._one(equation, operands)]

    def _one(self, equation: Any, operands: list[Any]) -> str:
        primitive, params = equation.primitive.name, equation.params
        shape = [int(size) for size in equation.outvars[0].aval.shape]
        if primitive in PLAIN:
            return self.node(PLAIN[primitive], operands)
        if primitive == "expm1":
            one = np.ones((), equation.invars[0].aval.dtype)
            return self.node("Sub", [self.node("Exp", operands), one])
        if primitive == "ne":
            return self.node("Not", [self.node("Equal", operands)])
        if primitive == "select_n":
            choice, no, yes = operands
            if equation.outvars[0].aval.dtype == bool:  # for which runtimes have no Where
                chosen = self.node("And", [choice, yes])
                return self.node("Or", [chosen, self.node("And", [self.node("Not", [choice]), no])])
            return self.node("Where", [choice, yes, no])
        if primitive == "clamp":
            low, value, high = operands
            return self.node("Min", [self.node("Max", [value, low]), high])
        if primitive == "integer_pow":
            dtype = equation.invars[0].aval.dtype
            return self.node("Pow", [operands[0], np.asarray(params["y"], dtype)])
        if primitive == "convert_element_type":
            kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(params["new_dtype"]))
            return self.node("Cast", operands, to=kind)
        if primitive in ("squeeze", "reshape", "expand_dims"):
            return self._reshaped(operands[0], shape)
        if primitive == "broadcast_in_dim":
            ones = [1] * len(shape)
            for place, axis in enumerate(params["broadcast_dimensions"]):
                ones[axis] = equation.invars[0].aval.shape[place]
            return self.node("Expand", [self._reshaped(operands[0], ones), np.asarray(shape)])
        if primitive == "concatenate":
            return self.node("Concat", operands, axis=params["dimension"])
        if primitive == "stack":
            axis = params.get("axis", params.get("dimension", 0))
            return self._stacked(operands, shape, axis)
        if primitive == "tile":
            repeats = [
                after // before
                for after, before in zip(shape, equation.invars[0].aval.shape, strict=True)
            ]
            return self.node("Tile", [operands[0], np.asarray(repeats)])
        if primitive == "transpose":
            return self.node("Transpose", operands, perm=list(params["permutation"]))
        if primitive in ("reduce_sum", "reduce_max", "reduce_or", "reduce_and"):
            return self._reduced(primitive, operands[0], list(params["axes"]))
        return self._moved(equation, operands, shape)

    def _moved(self, equation: Any, operands: list[Any], shape: list[int]) -> str:
        """Returns parts of an array, or a product of two."""
        primitive, params = equation.primitive.name, equation.params
        if primitive == "slice":
            start, stop = list(params["start_indices"]), list(params["limit_indices"])
            steps = list(params["strides"] or [1] * len(start))
            return self._sliced(operands[0], start, stop, steps, list(range(len(start))))
        if primitive == "rev":
            axes = list(params["dimensions"])
            most = [-(2**31)] * len(axes)
            return self._sliced(operands[0], [-1] * len(axes), most, [-1] * len(axes), axes)
        if primitive == "gather" and not isinstance(operands[1], str):
            numbers = params["dimension_numbers"]
            array = equation.invars[0].aval
            offsets = range(len(shape) - array.ndim + 1, len(shape))
            if (
                tuple(numbers.collapsed_slice_dims) == tuple(numbers.start_index_map) == (0,)
                and tuple(numbers.offset_dims) == tuple(offsets)
                and tuple(params["slice_sizes"])[1:] == array.shape[1:]
            ):
                return self.node("Gather", [operands[0], np.asarray(operands[1])[..., 0]], axis=0)
        if primitive == "scatter" and not isinstance(operands[1], str):
            numbers = params["dimension_numbers"]
            if (
                not numbers.update_window_dims
                and tuple(numbers.inserted_window_dims) == (0,)
                and tuple(numbers.scatter_dims_to_operand_dims) == (0,)
            ):
                places = np.asarray(operands[1], np.int64)
                return self.node("ScatterND", [operands[0], places, operands[2]])
        if primitive == "dot_general":
            (left, right), (batch, _) = params["dimension_numbers"]
            if not batch and len(left) == 1:
                # MatMul takes the last axis of the one and the last but one of the other.
                dims = [variable.aval.ndim for variable in equation.invars]
                places = dims[0] - 1, max(dims[1] - 2, 0)
                operands = [
                    self._with_axis_at(operand, num, int(axis), place)
                    for operand, num, (axis,), place in zip(
                        operands, dims, (left, right), places, strict=True
                    )
                ]
                product = self.node("MatMul", operands)
                return product if math.prod(shape) != 1 else self._reshaped(product, shape)
        raise RunError(
            f"the controller holds the operation {primitive}, which cannot be put into ONNX yet; "
            "export its weights with --to npz"
        )

    def _reshaped(self, value: Any, shape: Sequence[int]) -> str:
        return self.node("Reshape", [value, np.asarray(shape, np.int64)])

    def _with_axis_at(self, value: Any, num: int, axis: int, place: int) -> Any:
        """Returns an array of so many axes with one of them moved to another place."""
        if axis == place:
            return value
        order = [each for each in range(num) if each != axis]
        order.insert(place, axis)
        if not isinstance(value, str):
            return np.transpose(value, order)
        return self.node("Transpose", [value], perm=order)

    def _sliced(self, value: Any, *parts: list[int]) -> str:
        start, stop, steps, axes = (np.asarray(part, np.int64) for part in parts)
        return self.node("Slice", [value, start, stop, axes, steps])

    def _stacked(self, operands: list[Any], shape: list[int], axis: int) -> str:
        thin = [*shape[:axis], 1, *shape[axis + 1 :]]
        parts = [
            self._reshaped(each, thin) if isinstance(each, str) else np.reshape(each, thin)
            for each in operands
        ]
        return self.node("Concat", parts, axis=axis)

    def _unstacked(self, equation: Any, operand: Any) -> list[str]:
        axis = equation.params.get("axis", equation.params.get("dimension", 0))
        parts = [
            self._sliced(operand, [place], [place + 1], [1], [axis])
            for place in range(len(equation.outvars))
        ]
        return [
            self._reshaped(part, [int(size) for size in variable.aval.shape])
            for part, variable in zip(parts, equation.outvars, strict=True)
        ]

    def _reduced(self, primitive: str, operand: Any, axes: list[int]) -> str:
        if primitive == "reduce_sum":
            return self.node("ReduceSum", [operand, np.asarray(axes, np.int64)], keepdims=0)
        if primitive == "reduce_max":
            return self.node("ReduceMax", [operand], axes=axes, keepdims=0)
        numbers = self.node("Cast", [operand], to=self._onnx.TensorProto.FLOAT)
        operator = "ReduceMax" if primitive == "reduce_or" else "ReduceMin"
        reduced = self.node(operator, [numbers], axes=axes, keepdims=0)
        return self.node("Cast", [reduced], to=self._onnx.TensorProto.BOOL)
