# The package as catkin builds it: the core, point files through PCL, the ROS border, the executables and all tests.
find_package(catkin REQUIRED COMPONENTS actionlib actionlib_msgs diagnostic_msgs diagnostic_updater dynamic_reconfigure geometry_msgs
             interactive_markers message_generation nodelet pluginlib rosbag roscpp rosgraph_msgs roslib sensor_msgs shape_msgs std_msgs
             std_srvs tf2 tf2_geometry_msgs tf2_msgs tf2_ros urdf visualization_msgs xmlrpcpp)
find_package(PCL REQUIRED COMPONENTS common filters io segmentation)
find_path(ASSIMP_INCLUDE_DIR assimp/Importer.hpp)
find_library(ASSIMP_LIBRARY assimp)

# The module of parameter sweeps, which the processes of a cluster import.
catkin_python_setup()

add_message_files(FILES DeformedUpdate.msg PinWrench.msg PointForce.msg Statistics.msg Tool.msg ToolArray.msg ToolPath.msg
                  Contact.msg ContactArray.msg
                  ToolStatus.msg ToolStatusArray.msg ToolWrench.msg ToolWrenchArray.msg)
add_service_files(FILES EditParticles.srv FitSurface.srv GrowSurface.srv List.srv Restore.srv SaveCloud.srv SelectRegion.srv SetMaterial.srv
                  Snapshot.srv Step.srv)
add_action_files(FILES Rollout.action)
generate_messages(DEPENDENCIES actionlib_msgs geometry_msgs sensor_msgs shape_msgs std_msgs)

# What other packages use (docs/cpp_api.md): the core, point files and scenes, and the messages. The ROS border is internal.
catkin_package(
  INCLUDE_DIRS include
  LIBRARIES deformable_surface_core deformable_surface_io
  CATKIN_DEPENDS actionlib_msgs geometry_msgs message_runtime sensor_msgs shape_msgs std_msgs
  DEPENDS EIGEN3)
# catkin's own rule takes any newer version. While the major version is 0, a minor version may change what is public.
include(CMakePackageConfigHelpers)
foreach(folder ${CATKIN_DEVEL_PREFIX}/share/${PROJECT_NAME}/cmake ${PROJECT_BINARY_DIR}/catkin_generated/installspace)
  write_basic_package_version_file(${folder}/${PROJECT_NAME}Config-version.cmake VERSION ${package_version}
                                   COMPATIBILITY SameMinorVersion)
endforeach()

file(GLOB io_sources CONFIGURE_DEPENDS src/io/cloud_filters*.cpp src/io/point_files*.cpp src/io/mesh_files.cpp src/io/mesh_output.cpp src/io/load_scene.cpp
     src/io/volume_files.cpp)
file(GLOB ros_sources CONFIGURE_DEPENDS src/ros/convert/*.cpp src/ros/node/*.cpp src/ros/simulate/*.cpp)
file(GLOB nodelet_sources CONFIGURE_DEPENDS src/ros/node/*nodelet.cpp)
list(FILTER ros_sources EXCLUDE REGEX "(_main|nodelet)\\.cpp$")

# Installed programs find the libraries beside them without a ROS environment.
set(CMAKE_INSTALL_RPATH "$ORIGIN/..;$ORIGIN")

# The core sees neither catkin's include directories nor PCL's.
add_library(deformable_surface_core ${core_sources})
target_include_directories(deformable_surface_core PUBLIC include)
target_include_directories(deformable_surface_core SYSTEM PUBLIC ${EIGEN3_INCLUDE_DIRS})
target_link_libraries(deformable_surface_core PUBLIC yaml-cpp Threads::Threads)

# PCL and assimp stay inside: the headers of io do not name them.
add_library(deformable_surface_io ${io_sources})
target_include_directories(deformable_surface_io SYSTEM PRIVATE ${PCL_INCLUDE_DIRS} ${ASSIMP_INCLUDE_DIR})
target_compile_definitions(deformable_surface_io PRIVATE ${PCL_DEFINITIONS})
target_link_libraries(deformable_surface_io PUBLIC deformable_surface_core PRIVATE ${PCL_LIBRARIES} ${ASSIMP_LIBRARY})

add_library(deformable_surface_ros ${ros_sources})
add_dependencies(deformable_surface_ros ${PROJECT_NAME}_generate_messages_cpp)
target_include_directories(deformable_surface_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_link_libraries(deformable_surface_ros PUBLIC deformable_surface_io ${catkin_LIBRARIES})

add_library(deformable_surface_nodelet ${nodelet_sources})
target_link_libraries(deformable_surface_nodelet PUBLIC deformable_surface_ros)

add_executable(deformable_surface_node src/ros/node/node_main.cpp)
target_link_libraries(deformable_surface_node deformable_surface_ros)
file(GLOB marker_sources CONFIGURE_DEPENDS src/ros/interactive_markers/*.cpp)
# The second is its old name, which goes with version 0.3. A link would not be a file that can be installed.
foreach(name deformable_surface_interactive_markers deformable_surface_hand)
  add_executable(${name} ${marker_sources})
  target_link_libraries(${name} deformable_surface_ros)
endforeach()
add_executable(simulate src/ros/simulate/simulate_main.cpp)
target_link_libraries(simulate deformable_surface_ros)
add_executable(parameters_page src/io/parameters_page_main.cpp)
target_link_libraries(parameters_page deformable_surface_core)
add_executable(interface_page src/ros/node/interface_page_main.cpp)
target_link_libraries(interface_page deformable_surface_ros)

# The scenes of contact of a surface with itself: scripts/contact_scenes builds it.
add_executable(contact_scenes EXCLUDE_FROM_ALL test/stability/contact_scenes_main.cpp)
target_include_directories(contact_scenes PRIVATE test)
target_link_libraries(contact_scenes deformable_surface_core)

# The benchmark over ROS: scripts/benchmark_ros builds it.
file(GLOB ros_benchmark_sources CONFIGURE_DEPENDS benchmark/ros/*.cpp)
add_executable(benchmark_ros EXCLUDE_FROM_ALL ${ros_benchmark_sources} benchmark/report.cpp)
target_include_directories(benchmark_ros PRIVATE benchmark test)
target_link_libraries(benchmark_ros deformable_surface_ros)
add_dependencies(benchmark_ros deformable_surface_node deformable_surface_nodelet)

install(TARGETS deformable_surface_core deformable_surface_io deformable_surface_ros deformable_surface_nodelet deformable_surface_node
        deformable_surface_interactive_markers deformable_surface_hand simulate parameters_page interface_page
        ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
        LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
        RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install_headers(${CATKIN_GLOBAL_INCLUDE_DESTINATION})
install(DIRECTORY launch rviz scenes DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
# They lie beside each other, since some use others.
catkin_install_python(PROGRAMS scripts/demo_client.py scripts/draw_cloud.py scripts/draw_sweep.py scripts/example_client.py scripts/follow_points.py
                      scripts/launched_node.py scripts/look_at_scan.py scripts/modelling_client.py
                      scripts/play_tracked.py scripts/point_files.py scripts/publish_scan.py scripts/scan_clouds.py
                      scripts/sweep scripts/tool_on_frame.py scripts/view_cloud.py
                      DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(FILES LICENSE nodelet_plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})

if(CATKIN_ENABLE_TESTING)
  find_package(rostest REQUIRED)
  find_package(roslaunch REQUIRED)
  # With something for the arguments that have no default; unattended, since tests do without rviz.
  find_package(rviz QUIET)
  file(GLOB launch_files RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS launch/*.launch)
  if(NOT rviz_FOUND)
    list(REMOVE_ITEM launch_files launch/window.launch)  # which has nothing but RViz in it
  endif()
  foreach(file ${launch_files})
    roslaunch_add_file_check(${file} bag:=a columns:=3 output:=a scan:=a topic:=a unattended:=true)
  endforeach()

  # Without gtest, catkin_add_gtest only warns and makes no target.
  function(add_unit_test name library)
    catkin_add_gtest(${name} ${ARGN})
    if(TARGET ${name})
      target_include_directories(${name} PRIVATE test)
      target_compile_definitions(${name} PRIVATE DEFORMABLE_SURFACE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
      target_link_libraries(${name} ${library} gtest_main)
    endif()
  endfunction()

  foreach(source ${core_tests})
    get_filename_component(name ${source} NAME_WE)
    add_unit_test(${name} "camera_frames;deformable_surface_core" ${source})
    if(TARGET ${name} AND source MATCHES "/test/physics/")
      target_link_libraries(${name} physics_problems)
    endif()
  endforeach()

  file(GLOB io_tests CONFIGURE_DEPENDS test/io/cloud_filters*_test.cpp test/io/point_files*_test.cpp test/io/load_scene_test.cpp
       test/io/mesh_output_test.cpp test/io/volume_files_test.cpp test/io/quiet_pcl_test.cpp
       test/scenario/*_test.cpp)
  foreach(source ${io_tests})
    get_filename_component(name ${source} NAME_WE)
    add_unit_test(${name} deformable_surface_io ${source})
  endforeach()
  if(TARGET quiet_pcl_test)
    target_include_directories(quiet_pcl_test SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
    target_link_libraries(quiet_pcl_test ${PCL_LIBRARIES})
  endif()

  file(GLOB ros_tests CONFIGURE_DEPENDS test/ros/*/*_test.cpp)
  foreach(source ${ros_tests})
    get_filename_component(name ${source} NAME_WE)
    add_unit_test(${name} deformable_surface_ros ${source})
  endforeach()
  # The other sources of that program are tested with a roscore.
  if(TARGET marker_way_test)
    target_sources(marker_way_test PRIVATE src/ros/interactive_markers/marker_way.cpp)
  endif()

  # The decoder reads what strangers send: its test runs under the sanitizers as well.
  add_unit_test(cloud_decoder_sanitized_test "${catkin_LIBRARIES}" test/ros/convert/cloud_decoder_test.cpp
                src/ros/convert/cloud_decoder.cpp src/base/value.cpp)
  if(TARGET cloud_decoder_sanitized_test)
    set(sanitizers -fsanitize=address,undefined -fno-sanitize=vptr -fno-sanitize-recover=all)
    target_include_directories(cloud_decoder_sanitized_test PRIVATE include)
    target_include_directories(cloud_decoder_sanitized_test SYSTEM PRIVATE ${EIGEN3_INCLUDE_DIRS} ${catkin_INCLUDE_DIRS})
    target_compile_options(cloud_decoder_sanitized_test PRIVATE ${sanitizers} -g)
    target_link_libraries(cloud_decoder_sanitized_test ${sanitizers})
  endif()

  # A test with a master of its own: NAME.test starts the nodes, NAME_rostest.cpp asks them.
  file(GLOB launch_tests CONFIGURE_DEPENDS test/ros/*/*.test)
  foreach(launch ${launch_tests})
    get_filename_component(name ${launch} NAME_WE)
    get_filename_component(folder ${launch} DIRECTORY)
    add_rostest_gtest(${name}_rostest ${launch} ${folder}/${name}_rostest.cpp)
    if(TARGET ${name}_rostest)
      add_dependencies(${name}_rostest deformable_surface_node deformable_surface_nodelet deformable_surface_interactive_markers
                       deformable_surface_hand
                       simulate)
      target_link_libraries(${name}_rostest deformable_surface_ros)
    endif()
  endforeach()

  # Programs in Python find the package's messages through devel/env.sh, which looks at what is there when it runs. ${CATKIN_ENV}
  # does not do: it keeps what was there at the first configuration, when no message had been generated yet.
  set(devel_env ${CATKIN_DEVEL_PREFIX}/env.sh)

  # Launch files for real uses, each with a master of its own; one whose scan is not at hand skips itself.
  foreach(case camera_bag demo demo_camera demo_interrupted demo_refused garment modelling modelling_plane poke record spaces
               towel_on_table track tracked)
    add_test(NAME launch_${case}
             COMMAND ${devel_env} ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/launch/check_launch.py ${case})
    set_tests_properties(launch_${case} PROPERTIES SKIP_RETURN_CODE 77)
  endforeach()

  # What the demo makes of a scan.
  add_test(NAME look_at_scan
           COMMAND ${devel_env} ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/scripts/look_at_scan_test.py)

  # Parameter sweeps: plans and tables, and real clusters on this machine, which skip themselves without Dask, or Slurm.
  foreach(case engine plan store command simulator local scheduler slurm calibration)
    add_test(NAME sweep_${case}
             COMMAND ${devel_env} ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/sweep/sweep_${case}_test.py)
    set_tests_properties(sweep_${case} PROPERTIES SKIP_RETURN_CODE 77)
  endforeach()

  # Packages that use the installed library.
  foreach(example example_package example_catkin_package)
    add_test(NAME ${example}
             COMMAND ${PROJECT_SOURCE_DIR}/test/example_package/check.sh ${CMAKE_BINARY_DIR} ${example})
  endforeach()

  # The window that these open; scripts/rviz_pictures looks at all of them. Skips itself without RViz.
  add_test(NAME window
           COMMAND ${devel_env} ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/launch/check_windows.py surface)
  set_tests_properties(window PROPERTIES SKIP_RETURN_CODE 77)

  # The program as scripts use it: its exit status says whether a scene ended as it states.
  add_test(NAME simulate_strict COMMAND simulate ${PROJECT_SOURCE_DIR}/scenes/cut.yaml --strict --quiet)

  # Three hosts in network namespaces; skips itself where they cannot be made.
  add_test(NAME hosts COMMAND ${devel_env} ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/hosts/check_hosts.py)
  set_tests_properties(hosts PROPERTIES SKIP_RETURN_CODE 77)

  find_program(CATKIN_LINT catkin_lint)
  if(CATKIN_LINT)
    add_test(NAME catkin_lint COMMAND ${CATKIN_LINT} -q -W1 --strict ${PROJECT_SOURCE_DIR})
  endif()
endif()
