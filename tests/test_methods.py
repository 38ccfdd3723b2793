"""The form-factor method of a room, and that plan, forecast and record name the method used."""

from dataclasses import replace

import pytest

from renderer.records.json_records import of_run
from renderer.solving.forecast import forecast
from renderer.solving.plan import make_plan, make_reading_plan
from renderer.solving.solution import solve
from renderer.transport.factors.method import ExactFactors, HemisphereRays, PairRays

CRATE = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
METER = {"name": "floor", "position": [0.5, 0.5, 0.0]}
SOLVES = [((), None, ExactFactors), ([CRATE], None, PairRays), ([CRATE], 0.14, HemisphereRays)]


@pytest.mark.parametrize(("objects", "patch_size", "kind"), SOLVES)
def test_a_record_names_the_method_that_the_plan_chose(room, objects, patch_size, kind):
    scene = room(0.5, objects=objects, photometers=[METER])
    plan = make_plan(scene, 0.05, patch_size)
    solution = solve(scene, "rgb", plan=plan)
    method, mesh = solution.transport.method, solution.transport.mesh
    assert isinstance(method, kind)
    assert of_run(solution, 0.05, 0.0)["method"] == kind.name
    pairs = method.doubtful(mesh, solution.transport.exchange.areas)
    chosen = plan.method(mesh.count, None if pairs is None else pairs / mesh.count**2)
    assert (type(chosen), chosen.rays_per_patch) == (kind, plan.rays)
    assert chosen.replicas(mesh.count) == solution.transport.replicas


def test_meters_read_by_paths_take_hemispheres_where_something_stands(room):
    scene = room(0.5, objects=[CRATE], photometers=[METER])
    plan = make_reading_plan(scene, 0.05, None, 1)
    assert plan.gathered
    solution = solve(scene, "rgb", plan=plan)
    assert of_run(solution, 0.05, 0.0)["method"] == HemisphereRays.name == forecast(scene, "rgb", 0.05).method


@pytest.mark.parametrize(("objects", "kind"), [((), ExactFactors), ([CRATE], PairRays)])
def test_a_forecast_names_the_method_that_then_runs(room, objects, kind):
    # Fine enough that meters are read element by element, on a mesh of the size given.
    scene = room(0.5, objects=objects, photometers=[METER], solver={"patch_size": 0.4})
    assert forecast(scene, "rgb", 0.001).method == kind.name
    solution = solve(scene, "rgb", plan=make_reading_plan(scene, 0.001, 0.4, 1))
    assert isinstance(solution.transport.method, kind)


def test_the_rays_of_a_method_are_those_that_it_casts(room):
    scene = room(0.5, objects=[CRATE], luminaires=())
    for plan_rays, allowed in ((512, True), (512, False)):
        plan = replace(make_plan(scene, 0.05, 0.5), rays=plan_rays, pair_rays_allowed=allowed)
        transport = solve(scene, "rgb", plan=plan).transport
        assert isinstance(transport.method, PairRays if allowed else HemisphereRays)
        # Patches that the crate covers cast none.
        said = transport.method.rays_of_factors(transport.mesh.count)
        assert 0.9 * said <= transport.rays <= 1.1 * said
