"""A rotor whose speed sweeps, by integration over time.

The second route to what `problems/rotor/extension/run_up.py` has in closed form.
"""

import numpy as np
import scipy.linalg
from scipy.integrate import solve_ivp

from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance
from problems.rotor.response.dense import channel_rows, dynamic_stiffness
from problems.rotor.response.unknowns import rotor_at

FAR = (
    0.5,
    1.3,
)  # of the lowest speed in a run-up, of the highest in a coast-down: the start has died out at the next rows


def swept_response(problem, x, rate, n_mode=10):
    """The response (n_speed, n_channel) of a rotor at values x (d,) SI.

    Its lowest modes (on undamped bearings) as integrated, the rest as steady.
    """
    rotor = rotor_at(problem.rotor, problem.unknowns, x)
    whole, speed = assemble(rotor), problem.speed
    modes = scipy.linalg.eigh(whole.stiffness, whole.mass)[1][:, :n_mode]
    low = whole.on(modes)
    unbalance = modes.T @ force_per_unbalance(rotor, np.ones(1))[0] @ complex_unbalance(rotor)
    steady = np.linalg.solve(dynamic_stiffness(low, speed), speed[:, None, None] ** 2 * unbalance[:, None])[..., 0]
    start = FAR[0] * speed.min() if rate > 0 else FAR[1] * speed.max()
    change = swept(low, unbalance, speed, rate, start) - steady
    return problem.response(x[None])[0] + change @ (channel_rows(rotor, problem.channels) @ modes).T


def swept(matrices, unbalance, speed, rate, start):
    """Complex amplitudes (n_speed, m) of a swept linear system, by integration.

    M q̈ + (C + ΩG) q̇ + (K + ΩN) q = −u d²/dt² e^{iφ} at speeds (rad/s) on the way from `start` (rad/s) at a rate
    (rad/s²), at which the motion is the steady one.
    """
    m = len(unbalance)
    inverse = np.linalg.inv(matrices.mass)
    stiffness = inverse @ np.stack([matrices.stiffness, matrices.circulatory])
    damping = inverse @ np.stack([matrices.damping, matrices.gyroscopic])
    force = inverse @ unbalance

    def slope(time, state):  # of q e^{−iφ} and q̇ e^{−iφ}, which change slowly
        omega = start + rate * time
        motion, velocity = state[:m], state[m:]
        acceleration = (omega**2 - 1j * rate) * force - (stiffness[0] + omega * stiffness[1]) @ motion
        acceleration -= (damping[0] + omega * damping[1]) @ velocity
        return np.concatenate([velocity - 1j * omega * motion, acceleration - 1j * omega * velocity])

    steady = np.linalg.solve(
        stiffness[0] + start * stiffness[1] + 1j * start * (damping[0] + start * damping[1]) - start**2 * np.eye(m),
        start**2 * force,
    )
    time = (speed - start) / rate
    order = np.argsort(time)
    found = solve_ivp(
        slope,
        (0.0, time.max()),
        np.concatenate([steady, 1j * start * steady]),
        method="DOP853",
        t_eval=time[order],
        rtol=1e-9,
        atol=1e-13 * np.abs(steady).max(),
    )
    motion = np.empty((len(speed), m), dtype=complex)
    motion[order] = found.y[:m].T
    return motion
