# The core without catkin, and its tests where GoogleTest is installed.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
find_package(GTest)
enable_testing()

add_library(deformable_surface_core STATIC ${core_sources})
target_include_directories(deformable_surface_core PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(deformable_surface_core PUBLIC cxx_std_17)
target_link_libraries(deformable_surface_core PUBLIC Eigen3::Eigen yaml-cpp Threads::Threads)

# What find_package(deformable_surface) finds; docs/cpp_api.md.
set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/deformable_surface)
set_target_properties(deformable_surface_core PROPERTIES EXPORT_NAME core)
install(TARGETS deformable_surface_core EXPORT deformable_surface ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT deformable_surface NAMESPACE deformable_surface:: FILE deformable_surfaceTargets.cmake DESTINATION ${config_folder})
# While the major version is 0, a minor version may change what is public.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/deformable_surfaceConfigVersion.cmake VERSION ${package_version}
                                 COMPATIBILITY SameMinorVersion)
install(FILES cmake/deformable_surfaceConfig.cmake ${PROJECT_BINARY_DIR}/deformable_surfaceConfigVersion.cmake
        DESTINATION ${config_folder})
install_headers(${CMAKE_INSTALL_INCLUDEDIR})
if(NOT GTEST_FOUND)
  message(STATUS "GoogleTest was not found: no tests are built")
  set(core_tests "")
endif()
add_test(NAME example_package COMMAND ${PROJECT_SOURCE_DIR}/test/example_package/check.sh ${PROJECT_BINARY_DIR} example_package)

file(WRITE ${PROJECT_BINARY_DIR}/core_tests.txt "")  # their names, for scripts/sanitize
foreach(source ${core_tests})
  get_filename_component(name ${source} NAME_WE)
  file(APPEND ${PROJECT_BINARY_DIR}/core_tests.txt "${name}\n")
  add_executable(${name} ${source})
  target_include_directories(${name} PRIVATE test)
  target_link_libraries(${name} camera_frames deformable_surface_core GTest::gtest GTest::gtest_main)
  if(source MATCHES "/test/physics/")
    target_link_libraries(${name} physics_problems)
  endif()
  target_compile_definitions(${name} PRIVATE DEFORMABLE_SURFACE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  add_test(NAME ${name} COMMAND ${name})
endforeach()

# The benchmark prints the flags it was built with.
file(GLOB benchmark_sources CONFIGURE_DEPENDS benchmark/*.cpp)
add_executable(benchmark_core ${benchmark_sources})
target_link_libraries(benchmark_core physics_problems camera_frames deformable_surface_core)
get_directory_property(compile_options COMPILE_OPTIONS)
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
string(REPLACE ";" " " benchmark_flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}} ${compile_options}")
string(STRIP "${benchmark_flags}" benchmark_flags)
target_compile_definitions(benchmark_core PRIVATE DEFORMABLE_SURFACE_FLAGS="${benchmark_flags}"
  DEFORMABLE_SURFACE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# Other programs beside ours (--peers): those that are installed.
find_path(BULLET_INCLUDE_DIR BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h PATH_SUFFIXES bullet)
find_path(NANOFLANN_INCLUDE_DIR nanoflann.hpp)
if(BULLET_INCLUDE_DIR)
  target_include_directories(benchmark_core SYSTEM PRIVATE ${BULLET_INCLUDE_DIR})
  target_link_libraries(benchmark_core BulletSoftBody BulletDynamics BulletCollision LinearMath)
  target_compile_definitions(benchmark_core PRIVATE DEFORMABLE_SURFACE_WITH_BULLET)
endif()
if(NANOFLANN_INCLUDE_DIR)
  target_include_directories(benchmark_core SYSTEM PRIVATE ${NANOFLANN_INCLUDE_DIR})
  target_compile_definitions(benchmark_core PRIVATE DEFORMABLE_SURFACE_WITH_NANOFLANN)
endif()
find_path(PCL_FEATURES_INCLUDE_DIR pcl/features/normal_3d.h PATH_SUFFIXES pcl-1.12 pcl-1.13 pcl-1.14 pcl-1.15)
find_library(PCL_FEATURES_LIBRARY pcl_features)
find_library(LZ4_LIBRARY lz4)  # that FLANN's headers ask for
if(PCL_FEATURES_INCLUDE_DIR AND PCL_FEATURES_LIBRARY AND LZ4_LIBRARY)
  target_include_directories(benchmark_core SYSTEM PRIVATE ${PCL_FEATURES_INCLUDE_DIR})
  target_link_libraries(benchmark_core pcl_features pcl_search pcl_kdtree pcl_io pcl_common flann_cpp ${LZ4_LIBRARY})
  target_compile_definitions(benchmark_core PRIVATE DEFORMABLE_SURFACE_WITH_PCL)
endif()

# Other programs beside the growth of particles (--growth): programs of their own, built on request and never installed, since
# CGAL's packages are under the GPL.
find_path(CGAL_INCLUDE_DIR CGAL/Advancing_front_surface_reconstruction.h)
find_library(GMP_LIBRARY gmp)
find_library(MPFR_LIBRARY mpfr)
if(CGAL_INCLUDE_DIR AND GMP_LIBRARY AND MPFR_LIBRARY)
  add_executable(growth_by_cgal EXCLUDE_FROM_ALL benchmark/growth_peers/growth_by_cgal.cpp)
  target_include_directories(growth_by_cgal SYSTEM PRIVATE ${CGAL_INCLUDE_DIR})
  target_compile_features(growth_by_cgal PRIVATE cxx_std_17)
  target_compile_definitions(growth_by_cgal PRIVATE CGAL_EIGEN3_ENABLED)
  target_link_libraries(growth_by_cgal Eigen3::Eigen ${MPFR_LIBRARY} ${GMP_LIBRARY} Threads::Threads)
endif()
find_path(PCL_SURFACE_INCLUDE_DIR pcl/surface/poisson.h PATH_SUFFIXES pcl-1.12 pcl-1.13 pcl-1.14 pcl-1.15)
find_library(PCL_SURFACE_LIBRARY pcl_surface)
if(PCL_SURFACE_INCLUDE_DIR AND PCL_SURFACE_LIBRARY AND LZ4_LIBRARY)
  add_executable(growth_by_pcl EXCLUDE_FROM_ALL benchmark/growth_peers/growth_by_pcl.cpp)
  target_include_directories(growth_by_pcl SYSTEM PRIVATE ${PCL_SURFACE_INCLUDE_DIR})
  target_compile_features(growth_by_pcl PRIVATE cxx_std_17)
  target_link_libraries(growth_by_pcl Eigen3::Eigen pcl_surface pcl_search pcl_kdtree pcl_common flann_cpp ${LZ4_LIBRARY})
endif()
