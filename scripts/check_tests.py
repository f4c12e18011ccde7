#!/usr/bin/env python3
"""Checks that every source below src/solve, src/model and src/simulation has a test of its own, or is listed below with the test that
covers it. No compiler says this, and a new source without a test is easily overlooked.
A test of its own is test/ROOM/NAME_test.cpp or test/ROOM/FOLDER_NAME_test.cpp, with the name of the source and of its folder.
  check_tests.py [REPOSITORY]    one line for each source without a test and each stale entry; status 1 if there is any
  check_tests.py --self-test     shows on made-up files that each rule can fail"""
import os

import repository_check

ROOMS = ("solve", "model", "simulation")

# Source: the tests that cover it, and why it has none of its own.
COVERED = {
    "solve/explicit_integrators.cpp": (["solve/integrator"], "all integrators share one test of their order and energy"),
    "simulation/part_motion_limit.cpp": (["simulation/sleeping_parts", "contact/part_clearance"], "it acts while parts sleep"),
    "simulation/contact_areas.cpp": (["simulation/soft_pad"], "areas count where pads lie on them"),
    "solve/implicit_integrators.cpp": (["solve/integrator"], "all integrators share one test of their order and energy"),
    "model/elastic_solid/solid_passes.cpp": (["model/elastic_solid"], "the loops of the model's forces, energy and stiffness"),
    "model/elastic_solid/solid_part.cpp": (["model/elastic_solid_part"], "the test has the name of the model"),
    "model/mass_spring/clamped_plate.cpp": (["model/clamps"], "clamps are tested by the bending that they cause"),
    "model/mass_spring/curvature_bending.cpp": (["model/mass_spring", "model/moment_balance", "model/clamps"],
                                                "its forces, energy and stiffness are those of the model's bending"),
    "model/mass_spring/curvature_fits.cpp": (["model/moment_balance"], "the balance of moments is that of the fits"),
    "model/mass_spring/mass_spring_couplings.cpp": (["solve/quasi_newton", "solve/surface_preconditioner"],
                                                    "the springs are judged by what they precondition"),
    "model/mass_spring/triangle_energy.cpp": (["model/triangle_membrane"], "a part of TriangleMembrane"),
    "model/mass_spring/triangle_forces.cpp": (["model/triangle_membrane"], "a part of TriangleMembrane"),
    "model/mass_spring/triangle_patches.cpp": (["model/triangle_membrane"], "a part of TriangleMembrane"),
    "model/mass_spring/triangle_stiffness.cpp": (["model/triangle_membrane"], "a part of TriangleMembrane"),
    "model/oriented_particles/particle_bonds.cpp": (["model/kept_bonds", "model/particle_cuts", "model/oriented_particles_states"],
                                                    "kept bonds, cuts and layers have tests of their own"),
    "model/oriented_particles/particle_shape.cpp": (["model/oriented_particles_material", "model/oriented_particles_states",
                                                     "model/plastic_flow"], "a part of OrientedParticles"),
    "model/oriented_particles/particle_spacing.cpp": (["model/oriented_particles_material"], "a part of OrientedParticles"),
    "model/oriented_particles/particle_stable_step.cpp": (["model/oriented_particles", "model/kept_stiffness"],
                                                          "a part of OrientedParticles"),
    "model/oriented_particles/particle_surface.cpp": (["model/oriented_particles_material", "model/particle_topology"],
                                                      "a part of OrientedParticles"),
    "model/oriented_particles/particle_part.cpp": (["simulation/sleeping_particles"], "parts are stepped beside the whole"),
    "simulation/behind_noise.cpp": (["simulation/camera_clouds"], "needs clouds of a depth camera"),
    "simulation/between_touch.cpp": (["simulation/contact_load"], "judged by the touches and the potential beside an edge"),
    "simulation/contact_choice.cpp": (["simulation/tunnelling", "physics/contact_problems"],
                                      "chosen points are judged by what they hold, and by the energy that they keep"),
    "simulation/contact_crossings.cpp": (["simulation/tunnelling"], "tested by tools that pass through points in a step"),
    "simulation/cut_transfer.cpp": (["simulation/cutting"], "the transfer is tested with the cut that it follows"),
    "simulation/dynamics_commands.cpp": (["simulation/dynamics"], "a part of Dynamics"),
    "simulation/dynamics_constraints.cpp": (["simulation/clamp_edges", "simulation/moving_pins"], "a part of Dynamics"),
    "simulation/dynamics_memory.cpp": (["simulation/refused_steps", "determinism/snapshot", "determinism/fork"],
                                       "a part of Dynamics"),
    "simulation/dynamics_reactions.cpp": (["simulation/reactions", "simulation/snapped"], "a part of Dynamics"),
    "simulation/dynamics_sleep.cpp": (["simulation/sleeping_parts", "simulation/sleeping_particles"], "a part of Dynamics"),
    "simulation/dynamics_step.cpp": (["simulation/dynamics", "simulation/refused_steps", "simulation/parts"],
                                     "a part of Dynamics"),
    "simulation/half_frame.cpp": (["simulation/camera_clouds"], "needs clouds of a depth camera"),
    "simulation/models/elastic_solid/kind.cpp": (["simulation/model_kind", "simulation/scene_rules"],
                                                 "all models share the tests of rules and traits"),
    "simulation/models/elastic_solid/rest_filled.cpp": (["simulation/filled_solid"], "the test has the name of the feature"),
    "simulation/models/elastic_solid/rest_solid.cpp": (["simulation/solid_simulation"], "the test has the name of the feature"),
    "simulation/models/elastic_solid/skin.cpp": (["simulation/solid_contact"], "the test has the name of the feature"),
    "simulation/models/mass_spring/kind.cpp": (["simulation/model_kind", "simulation/scene_rules"],
                                               "all models share the tests of rules and traits"),
    "simulation/models/mass_spring/rest.cpp": (["simulation/rest_surface"], "the rest state is tested through its one entrance"),
    "simulation/models/oriented_particles/follower.cpp": (["simulation/population"], "needs particles that come and go"),
    "simulation/models/oriented_particles/kind.cpp": (["simulation/model_kind", "simulation/scene_rules"],
                                                      "all models share the tests of rules and traits"),
    "simulation/models/oriented_particles/grown_surface.cpp": (["simulation/particle_life", "simulation/settle_particles"],
                                                              "a part of ParticleLife"),
    "simulation/models/oriented_particles/particle_births.cpp": (["simulation/particle_life", "simulation/population"],
                                                                "a part of ParticleLife"),
    "simulation/models/oriented_particles/particle_guide.cpp": (["simulation/guide_load"], "a part of ParticleLife"),
    "simulation/models/oriented_particles/quantities.cpp": (["simulation/particle_life", "simulation/expectations"],
                                                            "quantities of `expect` are tested by name"),
    "simulation/models/oriented_particles/rest.cpp": (["simulation/settle_particles", "simulation/odd_particle_clouds"],
                                                      "the rest state is tested by what settles"),
    "simulation/models/registry.cpp": (["simulation/model_kind", "simulation/own_model"], "a list"),
    "simulation/quantities.cpp": (["simulation/expectations"], "a table, of which each name is asked for"),
    "simulation/rest_steps.cpp": (["simulation/rest_surface", "simulation/parts"], "the steps are tested in their order"),
    "simulation/scene_params.cpp": (["io/scene", "simulation/scene_rules"], "schemas are tested by reading, printing and checking"),
    "simulation/snapshot.cpp": (["determinism/snapshot", "determinism/fork", "simulation/viewer"], "a part of Simulation"),
    "simulation/tool_arrival.cpp": (["simulation/appearing_tool"], "the test has the name of the feature"),
    "simulation/tool_forces.cpp": (["simulation/reactions"], "sums of the loads of contact, as tools report them"),
    "simulation/unconstrained_parts.cpp": (["simulation/parts"], "one test for parts, held or not"),
}


def find_problems(sources, tests, covered):
    """Sentences, one for each source or entry that is wrong. sources: as in COVERED; tests: as there, "ROOM/NAME"."""
    problems = []
    for source in sorted(sources):
        folder, name = os.path.split(source[: -len(".cpp")])
        room = source.split("/")[0]
        own = sorted({room + "/" + name, room + "/" + os.path.basename(folder) + "_" + name} & tests)
        if own and source in covered:
            problems.append("%s: found in COVERED, but it has %s; accepted: one of both" % (source, own[0]))
        if not own and source not in covered:
            problems.append("%s: found no test/%s/%s_test.cpp; accepted: one, or an entry in COVERED of scripts/check_tests.py"
                            % (source, room, name))
    for source, (by, _) in sorted(covered.items()):
        if source not in sources:
            problems.append("%s: found in COVERED, but there is no such source; accepted: sources" % source)
        problems += ["%s: found no test/%s_test.cpp; accepted: tests" % (source, test) for test in by if test not in tests]
    return problems


def list_files(repository, top, ending):
    """Files below a folder, without their ending, relative to it."""
    root = os.path.join(repository, top)
    return {os.path.relpath(os.path.join(folder, name), root)[: -len(ending)]
            for folder, _, names in os.walk(root) for name in names if name.endswith(ending)}


def check_tree(repository):
    """Sentences, one for each source or entry that is wrong, and the number of sources."""
    sources = {name + ".cpp" for name in list_files(repository, "src", ".cpp") if name.split("/")[0] in ROOMS}
    if not sources:
        return [], 0
    return find_problems(sources, list_files(repository, "test", "_test.cpp"), COVERED), len(sources)


def test_self():
    """Each made-up set of files and how many problems it has. Returns the cases judged wrongly, and their number."""
    cases = [
        ({"model/a.cpp"}, {"model/a"}, {}, 0),
        ({"model/x/parts.cpp"}, {"model/x_parts"}, {}, 0),
        ({"model/x/parts.cpp"}, {"simulation/parts"}, {}, 1),
        ({"model/a.cpp"}, {"model/b"}, {"model/a.cpp": (["model/b"], "")}, 0),
        ({"model/a.cpp"}, {"model/a", "model/b"}, {"model/a.cpp": (["model/b"], "")}, 1),
        ({"model/a.cpp"}, set(), {"model/a.cpp": (["model/b"], "")}, 1),
        (set(), {"model/b"}, {"model/a.cpp": (["model/b"], "")}, 1),
    ]
    wrong = ["judged wrongly: %s" % (case,) for case in cases if len(find_problems(*case[:3])) != case[3]]
    return wrong, len(cases)


if __name__ == "__main__":
    repository_check.run(check_tree, test_self, "no source file found")
