# The headers that other packages see, and the rule that installs them. All others are internal and stay in the source tree.
# scripts/check_headers.py compares both lists with what the headers include and with docs/cpp_api.md.

# For users: docs/cpp_api.md describes each of them.
set(public_headers
    base/error.h
    base/version.h
    cloud/point_cloud.h
    io/cloud_filters.h
    io/load_scene.h
    io/point_files.h
    io/scene.h
    io/shapes.h
    simulation/commands.h
    simulation/scene_params.h
    simulation/simulation.h)

# What those include. Their types are used through the headers above, never by including these.
set(included_headers
    base/or_auto.h
    base/params.h
    base/types.h
    base/value.h
    cloud/kd_tree.h
    cloud/neighbors_params.h
    cloud/simplification_params.h
    contact/friction_anchors.h
    geometry/polyhedron.h
    geometry/region.h
    geometry/region_params.h
    geometry/signed_distance.h
    geometry/solid.h
    geometry/solid_params.h
    geometry/volume.h
    linear/block_sparse.h
    model/capabilities.h
    model/deformable_model.h
    model/elastic_solid/elastic_solid_params.h
    model/elastic_solid/plasticity_params.h
    model/mass_spring/mass_spring_params.h
    model/material_params.h
    model/state.h
    model/oriented_particles/growth_params.h
    model/oriented_particles/guide_params.h
    model/oriented_particles/oriented_particles_params.h
    simulation/accuracy_choice.h
    simulation/sleep_params.h
    simulation/contact_params.h
    simulation/input_filter_params.h
    simulation/model_params.h
    simulation/observed_cloud.h
    simulation/particle_edit.h
    simulation/run_time_params.h
    simulation/statistics.h
    simulation/tool_reaction.h
    solve/integrator_params.h
    tool/robot_params.h
    tool/tool.h
    tool/tool_modes.h
    tool/tool_params.h
    transfer/transfer_params.h)

# install_headers(FOLDER): below it, with their folders.
function(install_headers destination)
  foreach(header ${public_headers} ${included_headers})
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES include/deformable_surface/${header} DESTINATION ${destination}/deformable_surface/${folder})
  endforeach()
endfunction()
