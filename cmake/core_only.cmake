# The core and its tests without catkin.
find_package(GTest REQUIRED)
enable_testing()

add_library(deformable_surface_core STATIC ${core_sources})
target_include_directories(deformable_surface_core PUBLIC include)
target_include_directories(deformable_surface_core SYSTEM PUBLIC ${EIGEN3_INCLUDE_DIRS})
target_link_libraries(deformable_surface_core PUBLIC yaml-cpp Threads::Threads)

foreach(source ${core_tests})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_include_directories(${name} PRIVATE test)
  target_link_libraries(${name} deformable_surface_core GTest::gtest GTest::gtest_main)
  if(source MATCHES "/test/physics/")
    target_link_libraries(${name} physics_problems)
  endif()
  target_compile_definitions(${name} PRIVATE DEFORMABLE_SURFACE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  add_test(NAME ${name} COMMAND ${name})
endforeach()

# The benchmark prints the flags it was built with.
file(GLOB benchmark_sources CONFIGURE_DEPENDS benchmark/*.cpp)
add_executable(benchmark_core ${benchmark_sources})
target_link_libraries(benchmark_core physics_problems deformable_surface_core)
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
