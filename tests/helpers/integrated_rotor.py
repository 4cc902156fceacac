"""Steady-state motion of a rotor with nonlinear forces by integration over time.

It is the second route to harmonic balance.
"""

from math import cos, sin

import numpy as np
import scipy.linalg
from scipy.integrate import odeint

from problems.rotor.finite_elements.assembly import assemble, displacement_row
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance
from problems.rotor.response.dense import channel_rows, dynamic_stiffness
from problems.rotor.response.unknowns import rotor_at

N_PER_TURN = 64  # samples
N_TURN = 60  # at a speed, of which the last one counts
N_WAY, N_TURN_ON_WAY = 10, 15  # speeds from one to the next, and turns at each


def integrated_jeffcott(stiffness, damping, unbalance, force_at, speeds, harmonics=(1, 3)):
    """Harmonics (n_speed, n_harmonic, 2) of a unit mass on springs (x, y) and a damper.

    Speeds follow one after the other with a slow run between them. `force_at(x, y)` is the force (x, y) at a motion.
    """
    state, found, last = np.zeros(4), [], speeds[0]
    for omega in speeds:
        for way in np.linspace(last, omega, N_WAY + 1)[1:]:
            state = _turns(stiffness, damping, unbalance, force_at, way, state, N_TURN_ON_WAY)[-1]
        motion = _turns(stiffness, damping, unbalance, force_at, omega, state, N_TURN)
        state, last = motion[-1], omega
        sampled = motion[-N_PER_TURN - 1 : -1, :2].T
        angle = 2 * np.pi * np.arange(N_PER_TURN) / N_PER_TURN
        found.append([2 * np.mean(sampled * np.exp(-1j * each * angle), axis=1) for each in harmonics])
    return np.array(found)


def _turns(stiffness, damping, unbalance, force_at, omega, state, n_turn):
    """States (x, y, and velocities) over turns of the shaft, the last one at whole turns."""
    (k_x, k_y), size = stiffness, unbalance * omega**2

    def slope(state, time):
        x, y, v_x, v_y = state
        f_x, f_y = force_at(x, y)
        a_x = f_x + size * cos(omega * time) - k_x * x - damping * v_x
        return v_x, v_y, a_x, f_y + size * sin(omega * time) - k_y * y - damping * v_y

    time = np.arange(n_turn * N_PER_TURN + 1) / N_PER_TURN * 2 * np.pi / omega
    return odeint(slope, state, time, rtol=1e-9, atol=1e-11)


def integrated_response(problem, x, positions, force_at, n_mode=8, n_turn=100, n_step=128):
    """Response (n_speed, n_channel) at 1X of a rotor at values x (d,) SI with forces at positions (m).

    It starts from rest at every speed: its lowest modes (on undamped bearings) by the Runge–Kutta method of fourth
    order, the rest as linear. `force_at` makes forces (n_speed, 2) N of motions (n_speed, 2) m.
    """
    rotor, speed = rotor_at(problem.rotor, problem.unknowns, x), problem.speed
    whole = assemble(rotor)
    modes = scipy.linalg.eigh(whole.stiffness, whole.mass)[1][:, :n_mode]
    low = whole.on(modes)
    sites = [modes.T @ np.stack([displacement_row(rotor, position, axis) for axis in "xy"]).T for position in positions]
    exciting = modes.T @ (force_per_unbalance(rotor, speed) @ complex_unbalance(rotor)).T  # (n_mode, n_speed)
    linear = np.linalg.solve(dynamic_stiffness(low, speed), exciting.T[..., None])[..., 0]
    damping = low.damping + speed[:, None, None] * low.gyroscopic
    stiffness = low.stiffness + speed[:, None, None] * low.circulatory
    inverse = np.linalg.inv(low.mass)

    def slope(angle, state):  # per radian of the shaft
        motion, velocity = state
        force = (exciting.T * np.exp(1j * angle)).real
        force -= np.einsum("sij,sj->si", stiffness, motion) + np.einsum("sij,sj->si", damping, velocity)
        force += sum(force_at(motion @ site) @ site.T for site in sites)
        return np.stack([velocity, force @ inverse.T]) / speed[:, None]

    step, state, sampled = 2 * np.pi / n_step, np.zeros((2, len(speed), n_mode)), 0.0
    for number in range(n_turn * n_step):
        angle = number * step
        if number >= (n_turn - 1) * n_step:
            sampled = sampled + 2 * state[0] * np.exp(-1j * angle) / n_step
        first = slope(angle, state)
        second = slope(angle + step / 2, state + step / 2 * first)
        third = slope(angle + step / 2, state + step / 2 * second)
        fourth = slope(angle + step, state + step * third)
        state = state + step / 6 * (first + 2 * second + 2 * third + fourth)
    return problem.dense_response(x[None])[0] + (sampled - linear) @ (channel_rows(rotor, problem.channels) @ modes).T
