"""The generated LIGGGHTS input, word for word.  No solver needed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from adapters.particles.liggghts.input import bin_size_m, contact_model, cutoff_m, input_text, smallest_box_m
from orchestrator.ports.plans import GrainMaterial
from tests.particles.liggghts_plans import flat, make_plan, spheres

GOLDEN = """\
# Particles on a moving, deforming surface: input for LIGGGHTS-PUBLIC 3.8.0, written by flipflow.
# flipflow reads it line by line.  Atom type = number of the material, from 1.

units           si
atom_style      granular
newton          off
communicate     single vel yes
boundary        m m m           # grows with the particles (m): none can be lost unseen,
                                # and no bins are kept where there are none
hard_particles  yes
region          box block -0.025 0.025 -0.025 0.025 -0.005 0.015 units box
create_box      2 box
neighbor        0.000434 bin
neigh_modify    delay 0 binsize 0.00272
atom_modify     sort 1000 0.00272

fix youngs      all property/global youngsModulus peratomtype 2000000000.0 30000000.0
fix poisson     all property/global poissonsRatio peratomtype 0.3 0.48
fix restitution all property/global coefficientRestitution peratomtypepair 2 0.6 0.6 0.6 0.6
fix sliding     all property/global coefficientFriction peratomtypepair 2 0.4 0.4 0.4 0.4
fix rolling     all property/global coefficientRollingFriction peratomtypepair 2 0.1 0.1 0.1 0.1

pair_style      gran model hertz tangential history rolling_friction epsd2
pair_coeff      * *

fix gravity     all gravity 9.81 vector 0.0 0.0 -1.0
# The surface: flipflow's own wall, which gives the contacts found on its triangles to the
# contact model named here.  The plane only satisfies the stock syntax and is not used (for a
# run with LIGGGHTS alone, write wall/gran and place the plane).
fix surface     all wall/gran/flipflow model hertz tangential history rolling_friction epsd2 \
primitive type 1 zplane 0.0
fix motion      all nve/sphere
fix exits       all exits/flipflow  # takes particles out; where, it is told from memory
timestep        1e-06
# The surface's points and the particles follow from memory, then the first force evaluation:
"""


def test_input_word_for_word():
    plan = make_plan(
        flat(),
        spheres([0.0, 0.0, 0.01]),
        materials=(GrainMaterial("coal", 2e9, 0.3), GrainMaterial("polyurethane", 3e7, 0.48)),
        restitution=0.6,
        sliding_friction=0.4,
        rolling_friction=0.1,
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
    )
    assert input_text(plan) == GOLDEN


def test_effects_that_no_coefficient_calls_for_are_absent():
    plain = make_plan(flat(), spheres([0.0, 0.0, 0.01]))
    assert contact_model(plain) == "model hertz"
    for word in ("gravity", "Friction", "tangential", "rolling", "hard_particles"):
        assert word not in input_text(plain)
    assert "soft_particles  yes" in input_text(
        make_plan(flat(), plain.particles, materials=(GrainMaterial("soft", 1e6, 0.3),) * 2)
    )


def test_the_step_fills_the_interval_with_whole_steps():
    plan = make_plan(flat(), spheres([0.0, 0.0, 0.01]), step_s=3e-6)
    (words,) = (line.split() for line in input_text(plan).splitlines() if line.startswith("timestep"))
    assert float(words[1]) == 5e-5 / 17


def test_bins_cover_what_is_there_and_not_the_domain():
    plan = make_plan(flat(), spheres([0.0, 0.03, 0.05]), domain_m=np.array([[-50.0] * 3, [50.0] * 3]))
    corners_m = np.array([[-0.025, -0.025, -0.005], [0.025, 0.035, 0.055]])
    np.testing.assert_allclose(smallest_box_m(plan), corners_m, atol=1e-15)
    corners_m[:, 1] = [-50.0, 50.0]
    np.testing.assert_allclose(smallest_box_m(replace(plan, periodic_y=True)), corners_m)


def test_on_more_than_two_ranks_the_box_does_not_shrink():
    domain_m = np.array([[-50.0] * 3, [50.0] * 3])
    plan = make_plan(flat(), spheres([0.0, 0.03, 0.05]), domain_m=domain_m)
    on = {n: replace(plan, communicator=SimpleNamespace(size=n)) for n in (2, 3)}
    np.testing.assert_array_equal(smallest_box_m(on[2]), smallest_box_m(plan))
    np.testing.assert_allclose(smallest_box_m(on[3]), [[-50.005] * 3, [50.005] * 3])


def test_a_large_box_gets_large_bins():
    """Half a cutoff where there is room for that: a cube of 1 m has a million bins of 10 mm."""
    plan = make_plan(flat(), spheres([0.0, 0.03, 0.05]))
    assert bin_size_m(plan) == pytest.approx(cutoff_m(plan) / 2, rel=1e-2)
    large = replace(plan, particles=spheres([[0.0, 0.0, 0.5], [0.5, 0.5, 1.0], [-0.5, -0.5, 0.0]]))
    assert bin_size_m(large) == pytest.approx(1e-2, rel=2e-2)
