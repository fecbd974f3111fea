"""
19. Make it firmer, by gradients
================================

How hard a bowl can be pushed that stands on a tray on a narrow stand, by where it stands: plain gradient ascent, and
the same derivatives for PyTorch and JAX, where these are installed.
"""

from __future__ import annotations

import importlib.util

import numpy as np
from numpy.typing import NDArray

import holdfast as hf
from holdfast.sets import gradients

stand = hf.Body("stand", hf.Box((0.10, 0.10, 0.30)), position=(0, 0, -0.15), fixed=True)
tray = hf.Body("tray", hf.Box((0.30, 0.20, 0.02)), mass=0.4, position=(0, 0, 0.01))
bowl = hf.Body("bowl", hf.Cylinder(0.05, 0.08), mass=1.0, position=(0.06, 0.03, 0.06))
assembly = hf.assemble(hf.Scene([stand, tray, bowl], hf.Friction(0.6)))

# the bowl is pushed at its rim from four sides, wherever it stands
sides = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], dtype=float)
rim = -0.05 * sides + [0, 0, 0.04]  # from the middle of the bowl


def pushed(place: NDArray[np.float64]) -> tuple[hf.answers.Assembly, hf.answers.Robustness]:
    """Return the assembly with the bowl at x, y [m], and how hard it can be pushed there."""
    there = assembly.moved({"bowl": hf.pose(float(place[0]), float(place[1]), 0.06)})
    return there, hf.robustness(there, "bowl", rim + np.append(place, 0.06), sides, engine="limit")


def least_and_slope(place: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return a smooth least push [N] at x, y [m] and its derivative (2,) [N/m]."""
    there, answer = pushed(place)
    slopes = gradients(there, answer, bodies=["bowl"])
    force, weights = slopes.soft_weights(0.05)
    return force, weights @ slopes.pose["bowl"][:, :2]


start = np.array([0.06, 0.03])
place = start
print(f"at the start  {pushed(place)[1].force.min():.3f} N")
step = 0.01  # [m]
for _ in range(12):
    slope = least_and_slope(place)[1]
    if np.linalg.norm(slope) < 1e-3:
        break
    onward = place + step * slope / np.linalg.norm(slope)
    if pushed(onward)[1].force.min() > pushed(place)[1].force.min():
        place = onward
    else:
        step /= 2
print(f"in the end    {pushed(place)[1].force.min():.3f} N, at {place.round(3)}")


def with_torch() -> None:
    """The same derivative by torch.autograd."""
    import torch

    class Least(torch.autograd.Function):  # type: ignore[misc]
        """The smooth least push [N] of a place (2,) [m]."""

        @staticmethod
        def forward(ctx: torch.autograd.function.FunctionCtx, place: torch.Tensor) -> torch.Tensor:
            force, slope = least_and_slope(place.detach().numpy())
            ctx.save_for_backward(torch.from_numpy(np.array(slope)))
            return torch.tensor(force, dtype=place.dtype)

        @staticmethod
        def backward(ctx: torch.autograd.function.FunctionCtx, above: torch.Tensor) -> torch.Tensor:
            return above * ctx.saved_tensors[0]

    where = torch.tensor(start, requires_grad=True)
    Least.apply(where).backward()
    print("torch", where.grad.numpy().round(4), "N/m")


def with_jax() -> None:
    """The same derivative by jax.grad."""
    import jax

    jax.config.update("jax_enable_x64", True)
    shapes = jax.ShapeDtypeStruct((), np.float64), jax.ShapeDtypeStruct((2,), np.float64)

    def asked(place: jax.Array) -> tuple[np.float64, NDArray[np.float64]]:
        force, slope = least_and_slope(np.asarray(place))
        return np.float64(force), np.asarray(slope)

    @jax.custom_vjp  # type: ignore[untyped-decorator]
    def least(place: jax.Array) -> jax.Array:
        return jax.pure_callback(asked, shapes, place)[0]

    least.defvjp(lambda place: jax.pure_callback(asked, shapes, place), lambda slope, above: (above * slope,))
    print("jax  ", np.asarray(jax.grad(least)(start)).round(4), "N/m")


print("numpy", least_and_slope(start)[1].round(4), "N/m")
for name, shown in (("torch", with_torch), ("jax", with_jax)):
    if importlib.util.find_spec(name):
        shown()
    else:
        print(f"{name} is not installed")
