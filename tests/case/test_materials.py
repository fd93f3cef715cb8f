"""The library of materials: what a case takes from it, and what the commands and the page say of it."""

from __future__ import annotations

import json
import math
import re
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.case.bed.contact_times import contact_moduli
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.hardness import youngs_modulus_Pa
from orchestrator.case.file.loss_curve import moduli
from orchestrator.case.file.plausible import RANGES
from orchestrator.case.materials.library import find, materials, pairs, shapes, slug, sources
from orchestrator.case.tables.case import Case
from orchestrator.cli.main import app
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import find_problems, warnings
from tests.cases import CASE, keys_and_kinds, load_case
from tools.material_reference.__main__ import material_reference

HEAD, _, REST = CASE.partition("[materials.PU]")
MACHINE = REST[REST.index("[screen.frames.driving]") :]
NAMED = HEAD + MACHINE.replace('material = "PU"', 'material = "polyurethane 85 Shore A"').replace(
    'material = "coal"', 'material = "limestone"'
)
PLATE = '\n[screen.surfaces.side]\nframe = "ground"\nmaterial = "steel"\ncorner_m = [0.0, -0.1, 0.0]\n'
PLATE += "edges_m = [[0.3, 0.0, 0.0], [0.0, 0.0, 0.1]]\n"


def case(folder: Path, text: str, *overrides: str) -> Case:
    return load_case(folder, text, overrides).case


def works(given: Case) -> set[float]:
    return {round(row.work_of_adhesion_J_per_m2, 9) for row in given.contacts}


def problems(folder: Path, text: str, *overrides: str) -> list[str]:
    return [str(problem) for problem in _problems(folder, text, *overrides)]


def kinds(folder: Path, text: str, *overrides: str) -> list[str]:
    return keys_and_kinds(_problems(folder, text, *overrides))


def _problems(folder: Path, text: str, *overrides: str) -> list[CaseProblem]:
    try:
        return find_problems(load_case(folder, text, overrides))
    except CaseError as error:
        return [*error.problems]


def test_every_number_is_within_its_range_and_every_source_is_used() -> None:
    rows = [*materials().values(), *pairs().values()]
    quantities = [each for row in rows for each in row.quantities.values()]
    quantities += [shape.rolling_friction for shape in shapes().values()]
    for each in quantities:
        assert each.low <= each.value <= each.high, each
        assert each.source, each
        low, high = RANGES.get(each.key, (-math.inf, math.inf))
        assert low <= each.low, each
        assert each.high <= high, each
    cited = {each.source_id for each in quantities}
    assert cited | {"gercek-2007"} == set(sources())


def test_every_grain_has_a_contact_with_itself_and_with_every_surface() -> None:
    kinds = {name: material.kind for name, material in materials().items()}
    grains = [name for name, kind in kinds.items() if kind == "grains"]
    surfaces = [name for name, kind in kinds.items() if kind != "grains"]
    wanted = {frozenset(pair) for pair in [*((name, name) for name in grains), *product(grains, surfaces)]}
    assert set(pairs()) == wanted


def test_a_case_takes_materials_and_contacts_by_name(tmp_path: Path) -> None:
    given = case(tmp_path, NAMED + PLATE)
    assert problems(tmp_path, NAMED) == []
    assert given.screen.panels["deck"].material == "polyurethane-85-Shore-A"
    assert set(given.materials) == {"limestone", "polyurethane-85-Shore-A", "steel"}
    assert given.materials["limestone"].density_kg_per_m3 == 2650.0
    contacts = {row.between: row for row in given.contacts}
    assert set(contacts) == {
        ("limestone", "limestone"),
        ("limestone", "polyurethane-85-Shore-A"),
        ("limestone", "steel"),
    }
    wall = pairs()[frozenset(("limestone", "steel"))].quantities
    row = contacts["limestone", "steel"]
    assert row.restitution == wall["restitution"].value
    assert row.sliding_friction == wall["sliding_friction"].value
    assert row.rolling_friction == shapes()["angular"].rolling_friction.value
    assert works(given) == {0.0}


@pytest.mark.parametrize(
    ("name", "hardness"), [("polyurethane 85 Shore A", (85, "A")), ("rubber 40 shore d", (40, "D"))]
)
def test_an_elastomer_has_the_modulus_of_its_hardness_and_its_loss_factor(
    tmp_path: Path, name: str, hardness: tuple[float, str]
) -> None:
    given = case(tmp_path, NAMED.replace("polyurethane 85 Shore A", name))
    material = given.materials[slug(name)]
    modulus_Pa, poisson = contact_moduli(material, None)
    assert modulus_Pa == pytest.approx(youngs_modulus_Pa(*hardness), rel=0.02)  # K is not infinite
    assert 0.48 < poisson < 0.5
    assert material.hyperelastic is not None
    branches = tuple((row.ratio, row.relaxation_s) for row in material.hyperelastic.maxwell)
    _, loss = moduli(branches, 2 * np.pi * np.geomspace(5.0, 500.0, 20))
    stiffer, _ = moduli(branches, 2 * np.pi * np.array([12.0, 100.0]))
    assert stiffer == pytest.approx([1.15, 1.32], abs=0.01)  # as docs/materials.md says
    assert loss == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize(
    ("name", "work_J_per_m2"), [("dry limestone", 0.0), ("moist limestone", 0.192), ("wet limestone", 0.576)]
)
def test_moist_grains_stick_in_all_their_contacts(tmp_path: Path, name: str, work_J_per_m2: float) -> None:
    given = case(tmp_path, NAMED.replace('"limestone"', f'"{name}"') + PLATE)
    assert works(given) == {work_J_per_m2}
    assert given.bed.particles["ball"].material == slug(name)


def test_materials_are_numbered_in_the_order_of_their_first_mention(tmp_path: Path) -> None:
    """Every process must give them the same numbers, and the order of a set differs between processes."""
    text = NAMED + PLATE + PLATE.replace("side", "other").replace("steel", "rubber 60 Shore A")
    assert list(case(tmp_path, text).materials) == [
        *("polyurethane-85-Shore-A", "steel", "rubber-60-Shore-A", "limestone")
    ]


def test_own_values_replace_the_library_key_by_key(tmp_path: Path) -> None:
    own = """
[materials.limestone]
density_kg_per_m3 = 2600.0
[[contacts]]
between = ["limestone", "limestone"]
sliding_friction = 0.7
bond_number = 2.0
"""
    given = case(tmp_path, NAMED + own)
    assert given.materials["limestone"].density_kg_per_m3 == 2600.0
    assert given.materials["limestone"].youngs_modulus_Pa == find("limestone").keys()["youngs_modulus_Pa"]
    (row,) = [row for row in given.contacts if row.between == ("limestone", "limestone")]
    assert (row.sliding_friction, row.restitution) == (0.7, 0.4)
    assert row.work_of_adhesion_J_per_m2 > 0
    assert len(given.contacts) == 2
    by_set = case(tmp_path, NAMED, "materials.limestone.density_kg_per_m3=2600")
    assert by_set.materials == given.materials


def test_a_material_of_another_name_may_be_like_one_of_the_library(tmp_path: Path) -> None:
    text = (
        NAMED.replace('"limestone"', '"stone"')
        + '\n[materials.stone]\nlike = "moist iron-ore"\npoisson_ratio = 0.2\n'
    )
    given = case(tmp_path, text)
    stone = given.materials["stone"]
    assert (stone.density_kg_per_m3, stone.poisson_ratio, stone.like) == (4500.0, 0.2, None)
    assert {row.between for row in given.contacts} == {
        ("stone", "stone"),
        ("stone", "polyurethane-85-Shore-A"),
    }
    assert works(given) == {0.192}


def test_grains_that_the_case_takes_over_need_an_empty_table_only(tmp_path: Path) -> None:
    (tmp_path / "grains.csv").write_text("x_m,y_m,z_m,sieve_size_m,material\n0.1,0.1,0.05,0.01,gravel\n")
    text = NAMED.replace('material = "limestone"', 'material = "gravel"') + "[materials.gravel]\n"
    given = case(tmp_path, text, "bed.table=grains.csv")
    assert given.bed.carried is not None
    assert ("gravel", "polyurethane-85-Shore-A") in {row.between for row in given.contacts}


def test_two_kinds_of_grains_have_the_means_of_their_own_contacts(tmp_path: Path) -> None:
    sand = MACHINE[MACHINE.index("[bed.particles.ball]") : MACHINE.index("[probes")]
    sand = sand.replace("ball", "grain").replace('"coal"', '"sticky sand"').replace("0.15", "0.1")
    given = case(tmp_path, NAMED + sand)
    (row,) = [row for row in given.contacts if set(row.between) == {"limestone", "sticky-sand"}]
    assert (row.restitution, row.sliding_friction) == pytest.approx((0.45, 0.55))
    assert row.work_of_adhesion_J_per_m2 == pytest.approx(1.92)  # the sand's


def test_the_shape_of_grains_gives_the_rolling_friction_of_contacts_that_give_none(tmp_path: Path) -> None:
    """The case's own shape counts before the library's; a contact's own number counts before both."""
    own = """
[materials.limestone]
shape = "rounded"
[[contacts]]
between = ["limestone", "limestone"]
rolling_friction = 0.7
"""
    row = {contact.between: contact.rolling_friction for contact in case(tmp_path, NAMED + own).contacts}
    rounded = shapes()["rounded"].rolling_friction.value
    assert row == {("limestone", "limestone"): 0.7, ("limestone", "polyurethane-85-Shore-A"): rounded}
    usual = case(tmp_path, NAMED).contacts
    assert {contact.rolling_friction for contact in usual} == {shapes()["angular"].rolling_friction.value}
    flaky = case(tmp_path, NAMED, "materials.limestone.shape=flaky").contacts
    assert {contact.rolling_friction for contact in flaky} == {shapes()["flaky"].rolling_friction.value}


def test_two_kinds_of_grains_have_the_mean_of_their_shapes(tmp_path: Path) -> None:
    gravel = MACHINE[MACHINE.index("[bed.particles.ball]") : MACHINE.index("[probes")]
    gravel = gravel.replace("ball", "grain").replace('"coal"', '"gravel"').replace("0.15", "0.1")
    given = case(tmp_path, NAMED + gravel)
    (row,) = [row for row in given.contacts if set(row.between) == {"limestone", "gravel"}]
    angular, rounded = (shapes()[name].rolling_friction.value for name in ("angular", "rounded"))
    assert row.rolling_friction == pytest.approx((angular + rounded) / 2)


def test_a_material_of_the_users_own_may_have_a_shape(tmp_path: Path) -> None:
    """The contacts of the test case's own coal then need no rolling friction, and keep what they give."""
    shaped = CASE.replace("[materials.coal]", '[materials.coal]\nshape = "flaky"')
    assert [row.rolling_friction for row in case(tmp_path, shaped).contacts] == [0.0, 0.0]
    without = re.sub("rolling_friction = .*", "", shaped)
    flaky = shapes()["flaky"].rolling_friction.value
    assert [row.rolling_friction for row in case(tmp_path, without).contacts] == [flaky, flaky]
    missing = re.sub("rolling_friction = .*", "", CASE)
    assert "contacts.0.rolling_friction" in problems(tmp_path, missing)[0]


def test_a_shape_that_no_contact_takes_is_said(tmp_path: Path) -> None:
    """All contacts of the test case's coal give a rolling friction of their own, which counts."""
    shaped = load_case(tmp_path, CASE, ["materials.coal.shape=angular"])
    (warning,) = [
        line for line in warnings(shaped) if "materials.coal.shape = angular changes nothing" in line
    ]
    assert "(0)" in warning
    flaky = load_case(tmp_path, NAMED, ["materials.limestone.shape=flaky"])
    assert not [line for line in warnings(flaky) if "changes nothing" in line]


@pytest.mark.parametrize("shape", ['"angluar"', '["angular"]', "3", '""'])
def test_a_shape_that_does_not_exist_is_one_problem(tmp_path: Path, shape: str) -> None:
    (message,) = problems(tmp_path, f"{NAMED}\n[materials.limestone]\nshape = {shape}\n")
    assert "materials.limestone.shape" in message
    assert "angular" in message


def test_only_grains_have_a_shape(tmp_path: Path) -> None:
    assert kinds(tmp_path, NAMED + PLATE, "materials.steel.shape=round") == [
        "materials.steel.shape: conflict"
    ]


def test_a_complete_material_has_nothing_to_do_with_the_library(tmp_path: Path) -> None:
    """The test case's own coal is complete, and a pair of it that is not given is not the library's."""
    without = CASE.replace('between = ["coal", "coal"]', 'between = ["PU", "PU"]')
    assert any(
        "coal and coal can meet but have no contact" in message for message in problems(tmp_path, without)
    )
    assert len(case(tmp_path, CASE).contacts) == 2


def test_the_resolved_case_has_all_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = load_case(tmp_path, NAMED.replace('"limestone"', '"moist limestone"') + PLATE)
    table = resolved_case(given)
    assert "moist limestone" not in json.dumps(table)
    monkeypatch.setattr("orchestrator.case.materials.fill_in.look_up", lambda name: None)
    again = load_case(tmp_path / "again", table).case
    assert again.materials == given.case.materials
    assert again.contacts == given.case.contacts


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("limestne", 'no material "limestne"; did you mean "limestone"?'),
        ("polyurethane", 'give its hardness, for example "polyurethane 85 Shore A"'),
        ("polyurethane 99 Shore A", "its hardness must be from 30 to 95 Shore A"),
        ("limestone 60 Shore A", "only elastomers are named with a hardness"),
        ("moist steel", "only grains are moist"),
        ("moist polyurethane 85 Shore A", "only grains are moist, and polyurethane is not a grain"),
        *(
            (f"polyurethane 85{scale}", 'in Shore A or D, for example "polyurethane 85 Shore A"')
            for scale in (" Shore B", " IRHD", "")
        ),
    ],
)
def test_unknown_names_are_refused_with_the_nearest(tmp_path: Path, name: str, text: str) -> None:
    complaint = next(
        line
        for line in problems(tmp_path, NAMED.replace('"limestone"', f'"{name}"'))
        if "no material" in line
    )
    assert complaint.startswith("case.toml bed.particles.ball.material: ")
    assert text in complaint
    like = problems(tmp_path, NAMED, f'materials.limestone.like="{name}"')
    assert any("materials.limestone.like" in line and text.rpartition("; ")[2] in line for line in like)


def test_a_material_has_other_names() -> None:
    named = find("moist raw coal")
    assert (named.material.name, named.moisture) == ("coal", "moist")
    names = [name for row in materials().values() for name in (row.name, *row.also)]
    assert len(set(names)) == len(names)


def test_an_unknown_material_asks_for_no_contacts(tmp_path: Path) -> None:
    text = NAMED.replace('"limestone"', '"limston"')
    assert kinds(tmp_path, text) == ["bed.particles.ball.material: unknown-name"]


def test_a_material_that_all_panels_of_a_deck_lack_is_said_once(tmp_path: Path) -> None:
    head, _, rest = NAMED.partition("[screen.panels.deck]")
    deck = """[screen.decks.deck]
material = "polyurethane"
frames = ["driving", "ground"]
panels = 3
slopes_deg = []
corner_m = [0.0, 0.0, 0.0]
length_m = 0.2
width_m = 0.2
thickness_m = 0.004
clamp_m = 0.019
tension_m = 0.002
pitch_m = 0.25
"""
    text = head + deck + rest[rest.index("[bed.particles.ball]") : rest.index("[probes")]
    assert kinds(tmp_path, text) == ["screen.decks.deck.material: unknown-name"]


def test_particles_of_a_material_that_is_no_grain_are_told_so(tmp_path: Path) -> None:
    """The library has no contacts of polyurethane with itself; a case may give them."""
    text = NAMED.replace('"limestone"', '"polyurethane 85 Shore A"')
    assert kinds(tmp_path, text) == ["contacts: missing"]


def test_nonsense_in_place_of_names_is_left_to_the_check_of_the_tables(tmp_path: Path) -> None:
    for nonsense in (
        "materials=3",
        "contacts=3",
        "contacts=[3]",
        "contacts=[{between=[1, 2]}]",
        "materials.limestone=[]",
    ):
        assert problems(tmp_path, NAMED, nonsense)


def test_the_command_lists_and_explains() -> None:
    def run(*words: str) -> Any:
        return CliRunner().invoke(app, ["materials", *words], env={"COLUMNS": "200"})

    listed = run()
    assert listed.exit_code == 0
    assert all(name in listed.output for name in materials())
    explained = run("moist", "limestone").output
    assert re.search(r"density_kg_per_m3.*2650.*kg/m3.*2300 to 2750.*typical", explained)
    assert "shape: angular (broken or crushed" in explained
    assert "rolling friction of 0.25 (range 0.15 to 0.4)" in explained
    adhesion = "a work of adhesion of 0.192 J/m2 (range 0.064 to 0.576; theory of single bridges of water"
    assert adhesion in explained
    assert "Fisher, R. A., Journal of Agricultural Science 16, 1926" in explained
    row = json.loads(run("moist", "limestone", "--json").output)["adhesion"]
    assert [row["value"], *row["range"]] == pytest.approx([0.192, 0.064, 0.576])
    assert (row["key"], row["unit"], row["source"][:6]) == ("work_of_adhesion_J_per_m2", "J/m2", "Fisher")
    content = json.loads(run("rubber", "60", "Shore", "A", "--json").output)
    law = content["case"]["hyperelastic"]
    assert 6 * (law["c10_Pa"] + law["c01_Pa"]) == pytest.approx(youngs_modulus_Pa(60, "A"))
    assert content["format_version"] == 1
    page = (Path(__file__).parents[2] / "docs/json-output.md").read_text()
    section = page.split("`flipflow materials NAME --json`", 1)[1].split("\n## ", 1)[0]
    cells = [row.split("|")[1] for row in section.splitlines() if row.startswith("| `")]
    assert set(re.findall("[a-z_]+", " ".join(cells))) == content.keys() - {"format_version"}
    assert {row["name"] for row in json.loads(run("--json").output)["materials"]} == set(materials())
    unknown = run("limestne")
    assert unknown.exit_code == 2
    assert 'did you mean "limestone"?' in unknown.output


def test_the_page_on_materials_is_the_library() -> None:
    page = Path(__file__).parents[2] / "docs/materials.md"
    assert page.read_text() == material_reference(), "python -m tools.material_reference > docs/materials.md"
