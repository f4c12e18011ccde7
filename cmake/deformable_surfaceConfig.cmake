# Installed by builds without catkin, which writes such a file itself.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_dependency(yaml-cpp)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/deformable_surfaceTargets.cmake)
set(deformable_surface_LIBRARIES deformable_surface::core)  # as with catkin
