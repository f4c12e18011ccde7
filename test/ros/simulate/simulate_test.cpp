// The program `simulate` from its command line to its files: exit status, one line per problem, no incomplete files.
#include "simulate_fixture.h"

#include "deformable_surface/Statistics.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/base/version.h"
#include "deformable_surface/io/point_files.h"

#include <rosbag/view.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <map>
#include <set>
#include <thread>

namespace deformable_surface::node::test {
namespace {

TEST_F(Simulate, RunsASceneAndTellsWhatItDid) {
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(err_, "");
  for (const char* line : {"points                100", "simulation points     40", "steps                 10",
                           "simulated time        0.1 s", "largest displacement", "real-time factor", "wall time", "state hash"})
    EXPECT_NE(out_.find(line), std::string::npos) << line << " in\n" << out_;
  EXPECT_EQ(run({"--quiet"}), 0);
  EXPECT_EQ(out_, "");
}

TEST_F(Simulate, PrintsHelpWithoutAScene) {
  EXPECT_EQ(runWithoutScene({"--help"}), 0);
  for (const char* option : {"--set", "--duration", "--final", "--frames", "--frame_rate", "--bag_in", "--topic", "--bag_out",
                             "--statistics", "--threads", "--quiet"})
    EXPECT_NE(out_.find(option), std::string::npos) << option;
}

TEST_F(Simulate, ChecksASceneAndTellsTheColumnsOfItsStatisticsWithoutARun) {
  EXPECT_EQ(run({"--check", "--statistics", path("s.csv"), "--final", path("f.ply")}), 0);
  EXPECT_EQ(countFiles(".csv") + countFiles(".ply"), 0);
  EXPECT_NE(out_.find("statistics max_speed\n"), std::string::npos);
  EXPECT_EQ(out_.find("skipped"), std::string::npos);  // a list of words
  EXPECT_EQ(run({"--check", "--set", "material.thicknes=1"}), 2);
  EXPECT_EQ(err_, "simulate: material.thicknes: unknown key; the nearest known one is material.thickness\n");
  EXPECT_EQ(run({"--check", "--set", "cloud={file: none.xyz}"}), 2);
  EXPECT_EQ(err_, "simulate: none.xyz: cannot be opened: No such file or directory\n");
}

TEST_F(Simulate, PrintsItsVersionWithoutAScene) {
  EXPECT_EQ(runWithoutScene({"--version"}), 0);
  EXPECT_EQ(out_, std::string(version()) + "\n");
}

// Each edge of a triangle in pieces: as many triangles as their square, and as many normals as points.
TEST_F(Simulate, WritesTheTrianglesBetweenParticlesAsCubicPatches) {
  const auto countFirst = [](const std::string& file, const std::string& word) {
    std::ifstream stream(file);
    std::size_t found = 0;
    for (std::string line; std::getline(stream, line);) found += line.rfind(word + " ", 0) == 0;
    return found;
  };
  std::size_t flat = 0;
  for (const std::string pieces : {"1", "3"}) {
    const std::string file = path(pieces + ".obj");
    ASSERT_EQ(run({"--set", "model=oriented_particles", "--set", "expect={}", "--mesh", file, "--mesh_pieces", pieces}), 0)
        << err_;
    EXPECT_EQ(countFirst(file, "v"), countFirst(file, "vn"));
    if (pieces == "1") flat = countFirst(file, "f");
  }
  EXPECT_GT(flat, 0u);
  EXPECT_EQ(countFirst(path("3.obj"), "f"), 9 * flat);
}

TEST_F(Simulate, RefusesWrongCommandLinesWithOneLineEach) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--durations"}, "--duration"},
      {{"--duration"}, "found nothing behind it"},
      {{"--duration", "0.105"}, "multiple of integrator.time_step"},
      {{"--duration", "nan"}, "duration"},
      {{"--duration", "-1"}, "duration"},
      {{"--duration", "soon"}, "duration"},
      {{"--threads", "-1"}, "threads"},
      {{"--set", "integrator.time_stepp=0.01"}, "integrator.time_step"},
      {{"--set", "integrator"}, "KEY=VALUE"},
      {{"--frame_rate", "10"}, "--frames"},
      {{"--frames", path("frames"), "--frame_rate", "0"}, "above 0"},
      {{"--frames", path("frames"), "--frame_rate", "1000"}, "one frame per step"},
      {{"--topic", "cloud_in=/points"}, "--bag_in"},
      {{"--bag_in", path("in.bag"), "--topic", "clouds=/points"}, "cloud_in, force, wrench, tools"},
      {{"--final", path("out.stl")}, ".ply"},
      {{"--final", path("missing/out.ply")}, "folder"},
      {{"--mesh", path("out.ply")}, ".obj"},
      {{"--mesh", path("missing/out.obj")}, "folder"},
      {{"--mesh", path("out.obj")}, "oriented_particles"},
      {{"--mesh_pieces", "2"}, "--mesh FILE.obj"},
      {{"--mesh", path("out.obj"), "--mesh_pieces", "0"}, "1 to 64"},
      {{"--statistics", path("missing/out.csv")}, "folder"},
      {{"--bag_out", path("missing/out.bag")}, "folder"},
      {{"--bag_out", folder_.string()}, "no file"},
      {{"--wrenches", path("missing/out.csv")}, "folder"},
      {{"--measure", "min_zz"}, "min_z"},
      {{"--bag_in", path("missing.bag")}, "missing.bag"},
      {{"--final", path("a.ply"), "--final", path("b.ply")}, "twice"},
      {{"second.yaml"}, "second"}};
  // What a run checks of the scene and the options, before it opens files, --check does.
  for (const auto& [arguments, sentence] : cases) {
    if (std::set<std::string>{"--final", "--mesh", "--filtered", "--frames"}.count(arguments[0]) == 0) continue;
    std::vector<std::string> checked = arguments;
    checked.push_back("--check");
    EXPECT_EQ(run(checked), 2) << arguments[0];
    EXPECT_NE(err_.find(sentence), std::string::npos) << sentence << " in " << err_;
  }
  for (const auto& [arguments, sentence] : cases) {
    EXPECT_EQ(run(arguments), 2) << arguments[0];
    EXPECT_EQ(countLines(err_), 1u) << arguments[0] << ":\n" << err_;
    EXPECT_NE(err_.find(sentence), std::string::npos) << sentence << " in " << err_;
  }
  EXPECT_EQ(countFiles(".partial"), 0);
  EXPECT_EQ(runWithoutScene({}), 2);
  EXPECT_EQ(runWithoutScene({path("missing.yaml")}), 2);
}

TEST_F(Simulate, NamesEveryProblemOnALineOfItsOwn) {
  EXPECT_EQ(run({"--duration", "0.105", "--set", "material.thickness=-1", "--set", "colour=red", "--fast"}), 2);
  EXPECT_EQ(countLines(err_), 1u) << err_;  // the command line first
  EXPECT_EQ(run({"--set", "material.thickness=-1", "--set", "colour=red"}), 2);
  EXPECT_EQ(countLines(err_), 2u) << err_;
}

TEST_F(Simulate, WritesTheFinalCloudWithNormalsAndDisplacement) {
  EXPECT_EQ(run({"--set", "gravity=[0, 0, -9.81]", "--final", path("out.ply")}), 0);
  const cloud::PointCloud cloud = io::readPointFile(path("out.ply"), 1.0, 1000);
  ASSERT_EQ(cloud.size(), 100);
  EXPECT_EQ(cloud.normals.size(), 100u);
  EXPECT_NEAR(cloud.positions[0].z(), -0.5 * 9.81 * 0.01, 1e-6);
  ASSERT_EQ(cloud.extra_fields.size(), 1u);
  EXPECT_EQ(cloud.extra_fields[0].name, "displacement");
  EXPECT_EQ(countFiles(".partial"), 0);
}

TEST_F(Simulate, WritesFramesFromTimeZeroOn) {
  EXPECT_EQ(
      run({"--set", "gravity=[0, 0, -9.81]", "--frames", path("a/frames"), "--frame_rate", "20", "--final", path("out.ply")}), 0);
  EXPECT_EQ(countFiles(".ply"), 4);
  EXPECT_EQ(io::readPointFile(path("a/frames/frame_000000.ply"), 1.0, 1000).positions[0].z(), 0.0);
  EXPECT_EQ(readFile(path("a/frames/frame_000002.ply")), readFile(path("out.ply")));
}

TEST_F(Simulate, WritesOneRowOfStatisticsPerStep) {
  EXPECT_EQ(run({"--statistics", path("out.csv")}), 0);
  const std::string text = readFile(path("out.csv"));
  EXPECT_EQ(countLines(text), 11u);
  EXPECT_EQ(text.substr(0, 21), "simulation_time,step,");
  const std::string header = text.substr(0, text.find('\n')), last = text.substr(text.rfind('\n', text.size() - 2) + 1);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(last.begin(), last.end(), ','));
  EXPECT_EQ(last.substr(0, last.find(',')), "0.10000000000000001");
}

TEST_F(Simulate, WritesARowOfWrenchesPerStepAndPin) {
  EXPECT_EQ(run({"--set", "gravity=[0, 0, -9.81]", "--set", "pins=[{box: {min: [-1, -1, -1], max: [-0.4, 1, 1]}}]", "--wrenches",
                 path("out.csv")}),
            0)
      << err_;
  const std::string text = readFile(path("out.csv"));
  EXPECT_EQ(countLines(text), 11u);
  EXPECT_EQ(text.substr(0, text.find('\n')), "simulation_time,step,id,force_x,force_y,force_z,torque_x,torque_y,torque_z");
  EXPECT_NE(text.find("\n0.01,1,pins[0],"), std::string::npos) << text;
}

TEST_F(Simulate, QuotesIdsOfToolsWithCommasInItsWrenches) {
  EXPECT_EQ(run({"--set", "tools=[{id: 'a \"b\", c', shape: {sphere: {radius: 0.1}}, path: [{position: [5, 5, 5]}]}]",
                 "--wrenches", path("out.csv")}),
            0)
      << err_;
  const std::string text = readFile(path("out.csv"));
  EXPECT_NE(text.find("\n0.01,1,\"a \"\"b\"\", c\",0,0,0,0,0,0\n"), std::string::npos) << text;
}

TEST_F(Simulate, PrintsMeasuredQuantitiesWithAllDigitsAndTellsWhichThereAreNot) {
  EXPECT_EQ(run({"--set", "gravity=[0, 0, -9.81]", "--measure", "min_z", "--measure", "volume_ratio"}), 0);
  const std::size_t found = out_.find("measured min_z ");
  ASSERT_NE(found, std::string::npos) << out_;
  EXPECT_NEAR(std::stod(out_.substr(found + 15)), -0.5 * 9.81 * 0.01, 1e-6);
  EXPECT_NE(out_.find("note: --measure: volume_ratio: found a surface with a boundary"), std::string::npos) << out_;
  EXPECT_EQ(run({"--measure", "springs"}), 0);
  EXPECT_NE(out_.find("measured springs "), std::string::npos) << out_;
  EXPECT_NE(out_.find("note: the quantity springs is now called links; "), std::string::npos) << out_;
  EXPECT_EQ(run({"--set", "activity.sleep=never"}), 0);
  EXPECT_NE(out_.find("note: activity.sleep is now called sleep.mode; "), std::string::npos) << out_;
}

TEST_F(Simulate, SaysWhyAMeasuredErrorIsInfinite) {
  EXPECT_EQ(run({"--set", "gravity=[0, 0, -9.81]", "--set", "pins=[{box: {min: [-1, -1, -1], max: [-0.4, 1, 1]}}]", "--set",
                 "integrator={type: static, max_iterations: 1}", "--measure", "error_estimate"}),
            0)
      << err_;
  EXPECT_NE(out_.find("measured error_estimate inf\n"), std::string::npos) << out_;
  EXPECT_NE(out_.find("note: error_estimate is measured as infinite: error_bounded is false, so that the estimate, "),
            std::string::npos)
      << out_;
}

TEST_F(Simulate, StopsWithStatusThreeAndTheLastGoodState) {
  // An explicit Euler step far beyond what the springs allow.
  EXPECT_EQ(run({"--set", "integrator={type: explicit_euler, time_step: 1.0}", "--set", "material={young_modulus: 1.0e9}",
                 "--set", "forces=[{id: pull, point: [0.5, 0.5, 0], force: [1, 1, 1]}]", "--duration", "1000", "--final",
                 path("out.ply"), "--statistics", path("out.csv"), "--bag_out", path("out.bag")}),
            3);
  EXPECT_NE(err_.find("step "), std::string::npos) << err_;
  EXPECT_EQ(countLines(err_), 1u);
  EXPECT_TRUE(fs::exists(path("out.ply")) && fs::exists(path("out.csv")) && fs::exists(path("out.bag")));
  EXPECT_EQ(countFiles(".partial"), 0);
}

TEST_F(Simulate, LeavesNothingBehindWhenItIsInterrupted) {
  stop_.number = SIGTERM;
  stop_.has_come = true;
  EXPECT_EQ(run({"--final", path("out.ply"), "--statistics", path("out.csv"), "--bag_out", path("out.bag")}), 128 + SIGTERM);
  EXPECT_EQ(countFiles(".ply") + countFiles(".csv") + countFiles(".bag") + countFiles(".partial"), 0);
  EXPECT_EQ(err_, "simulate: interrupted while a surface was built; no state of it is written\n");
}

TEST_F(Simulate, KeepsTheFramesUntilItIsInterrupted) {
  stop_.number = SIGTERM;
  std::atomic<bool> has_ended{false};
  std::thread signal([&] {
    while (!fs::exists(path("frames/frame_000000.ply")) && !has_ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop_.has_come = true;
  });
  EXPECT_EQ(run({"--frames", path("frames"), "--final", path("out.ply"), "--duration", "100000"}), 128 + SIGTERM);
  has_ended = true;
  signal.join();
  EXPECT_NE(err_.find("except the frames until then"), std::string::npos) << err_;
  EXPECT_EQ(countFiles("out.ply"), 0);
}

// Each row is written at once, so that the temporary files tell how far the run is.
TEST_F(Simulate, KeepsTheRowsOfTablesUntilItIsInterrupted) {
  stop_.number = SIGINT;
  std::atomic<bool> has_ended{false};
  std::thread signal([&] {
    while (countLines(readFile(path("w.csv.partial"))) < 3 && !has_ended)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop_.has_come = true;
  });
  EXPECT_EQ(run({"--set", "pins=[{box: {min: [-1, -1, -1], max: [-0.4, 1, 1]}}]", "--statistics", path("s.csv"), "--wrenches",
                 path("w.csv"), "--final", path("out.ply"), "--duration", "100000"}),
            128 + SIGINT);
  has_ended = true;
  signal.join();
  EXPECT_NE(err_.find("no output is written, except the rows of --statistics, the rows of --wrenches until then\n"),
            std::string::npos)
      << err_;
  EXPECT_GE(countLines(readFile(path("s.csv"))), 3u);
  EXPECT_EQ(countLines(readFile(path("s.csv"))), countLines(readFile(path("w.csv"))));
  EXPECT_EQ(countFiles("out.ply") + countFiles(".partial"), 0);
}

TEST_F(Simulate, RefusesToOverwriteWhatItReads) {
  writeBag("in.bag", [](rosbag::Bag&) {});
  EXPECT_EQ(run({"--final", path("frame_000000.ply")}), 0) << err_;
  fs::copy_file(path("in.bag"), path("late.bag.partial"));
  fs::create_symlink(path("in.bag"), path("soft.bag"));
  fs::create_hard_link(path("in.bag"), path("hard.bag"));
  fs::create_directory_symlink(folder_, path("again"));
  const std::string bag = readFile(path("in.bag")), cloud = readFile(path("frame_000000.ply"));
  const std::string from_file = "cloud={file: " + path("frame_000000.ply") + "}";
  const std::vector<std::vector<std::string>> cases{{"--bag_in", path("in.bag"), "--bag_out", path("in.bag")},
                                                    {"--bag_in", path("in.bag"), "--bag_out", path("soft.bag")},
                                                    {"--bag_in", path("soft.bag"), "--bag_out", path("hard.bag")},
                                                    {"--bag_in", path("in.bag"), "--statistics", path("again/in.bag")},
                                                    {"--bag_in", path("late.bag.partial"), "--bag_out", path("late.bag")},
                                                    {"--set", from_file, "--final", path("again/frame_000000.ply")},
                                                    {"--set", from_file, "--frames", path("again")},
                                                    {"--statistics", path("scene.yaml")},
                                                    {"--bag_out", path("new"), "--statistics", path("again/new")}};
  for (const std::vector<std::string>& arguments : cases) {
    EXPECT_EQ(run(arguments), 2) << arguments.back();
    EXPECT_EQ(countLines(err_), 1u) << arguments.back() << ":\n" << err_;
    EXPECT_NE(err_.find("accepted: another f"), std::string::npos) << err_;
  }
  EXPECT_EQ(readFile(path("in.bag")), bag);
  EXPECT_EQ(readFile(path("late.bag.partial")), bag);
  EXPECT_EQ(readFile(path("frame_000000.ply")), cloud);
  EXPECT_EQ(readFile(path("scene.yaml")), kScene);
  // Side by side they are accepted.
  EXPECT_EQ(run({"--set", from_file, "--final", path("other.ply"), "--frames", path("frames")}), 0) << err_;
}

TEST_F(Simulate, RefusesAFolderThatHoldsFramesAlready) {
  const std::vector<std::string> arguments{"--frames", path("frames"), "--final", path("out.ply")};
  ASSERT_EQ(run(arguments), 0) << err_;
  std::ofstream(path("frames/notes.txt")) << "kept";
  const int num_frames = countFiles(".ply") - 1;
  fs::remove(path("out.ply"));
  EXPECT_EQ(run(arguments), 2);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  EXPECT_NE(err_.find("frames of an earlier run in " + quote(path("frames"))), std::string::npos) << err_;
  EXPECT_EQ(countFiles(".ply"), num_frames);
  // A file that is no frame may be there.
  for (int i = 0; i < num_frames; ++i) fs::remove(path("frames/frame_00000" + std::to_string(i) + ".ply"));
  std::ofstream(path("frames/frame_of_the_film.ply"));
  EXPECT_EQ(run(arguments), 0) << err_;
}

TEST_F(Simulate, RefusesAnOutputWithTheNameOfAFrame) {
  fs::create_directory(path("frames"));
  EXPECT_EQ(run({"--frames", path("frames"), "--final", path("frames/frame_000000.ply")}), 2);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  EXPECT_NE(err_.find("--final"), std::string::npos) << err_;
  EXPECT_EQ(countFiles(".ply"), 0);
}

TEST_F(Simulate, WritesThroughSymbolicLinks) {
  fs::create_directory(path("shelf"));
  std::ofstream(path("shelf/old.csv")) << "old";
  const std::vector<std::pair<std::string, std::string>> links{
      {"out.csv", "shelf/old.csv"}, {"out.ply", "shelf/new.ply"}, {"out.bag", "shelf/new.bag"}};
  for (const auto& [link, target] : links) fs::create_symlink(target, path(link));  // relative to the folder of the link
  fs::create_symlink("out.ply", path("again.ply"));
  EXPECT_EQ(run({"--statistics", path("out.csv"), "--final", path("again.ply"), "--bag_out", path("out.bag")}), 0) << err_;
  for (const auto& [link, target] : links) {
    EXPECT_EQ(fs::read_symlink(path(link)), target);
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(path(target)))) << target;
  }
  EXPECT_TRUE(fs::is_symlink(path("again.ply")));
  EXPECT_EQ(countLines(readFile(path("shelf/old.csv"))), 11u);
  EXPECT_EQ(io::readPointFile(path("shelf/new.ply"), 1.0, 1000).size(), 100);
  EXPECT_EQ(countFiles(".partial"), 0);

  // Two links to one file that does not exist yet, and links to nowhere.
  fs::remove(path("shelf/new.bag"));
  fs::create_symlink("shelf/new.bag", path("rows.csv"));
  EXPECT_EQ(run({"--bag_out", path("out.bag"), "--statistics", path("rows.csv")}), 2);
  EXPECT_NE(err_.find("accepted: another file"), std::string::npos) << err_;
  fs::create_symlink("round.ply", path("round.ply"));
  EXPECT_EQ(run({"--final", path("round.ply")}), 2);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  fs::create_symlink("missing/new.ply", path("nowhere.ply"));
  EXPECT_EQ(run({"--final", path("nowhere.ply")}), 2);
  EXPECT_EQ(countLines(err_), 1u) << err_;
}

TEST_F(Simulate, EndsInOneLineWhenTheDiskIsFull) {
  const std::vector<std::string> arguments{"--bag_out", path("out.bag")};
  ASSERT_EQ(run(arguments), 0);
  const auto size = static_cast<rlim_t>(fs::file_size(path("out.bag")));
  fs::remove(path("out.bag"));
  // A limit on the size of files takes the place of a full disk: at the start of the bag, within it and at its end.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto on_limit = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t limit : {rlim_t{100}, size / 2, size - 100}) {
    const rlimit full{limit, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
    const int status = run(arguments);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_EQ(status, 2) << limit;
    EXPECT_EQ(err_, "simulate: " + path("out.bag") +
                        ": cannot be written; accepted: a file in a folder that can be written, with room on the disk\n");
    EXPECT_EQ(countFiles(".bag") + countFiles(".partial"), 0) << limit;
  }
  std::signal(SIGXFSZ, on_limit);
}

TEST_F(Simulate, NotesForcesOfTheSceneThatCannotDoWhatWasMeant) {
  EXPECT_EQ(run({"--set", "pins=[{box: {min: [-1, -1, -1], max: [-0.4, 1, 1]}}]", "--set",
                 "forces=[{id: late, point: [0, 0, 0], force: [0, 0, 1], start: 0.1},"
                 "{id: far, point: [0, 0, 9], force: [0, 0, 1], radius: 0.1},"
                 "{id: held, point: [-0.5, 0, 0], force: [0, 0, 1]}, {id: good, point: [0, 0, 0], force: [0, 0, 1]}]"}),
            0)
      << err_;
  EXPECT_NE(out_.find("note: force 'late' acts in no step: its time begins at 0.1 s"), std::string::npos) << out_;
  EXPECT_NE(out_.find("force 'far': no simulation point lies within its radius of 0.1 m"), std::string::npos) << out_;
  EXPECT_NE(out_.find("force 'held': the simulation point that it acts on is pinned"), std::string::npos) << out_;
  EXPECT_EQ(out_.find("'good'"), std::string::npos) << out_;
}

TEST_F(Simulate, NotesWhatIsNotAsExpected) {
  EXPECT_EQ(run({"--set", "expect={max_displacement: [1, 2], max_x: [0, 2]}"}), 0) << err_;
  EXPECT_NE(out_.find("note: not as expected: expect.max_displacement"), std::string::npos) << out_;
  EXPECT_EQ(out_.find("expect.max_x"), std::string::npos) << out_;
}

TEST_F(Simulate, LooksAtExpectationsAfterTheDurationOfTheSceneOnly) {
  const std::string expect = "expect={max_displacement: [1, 2]}";
  EXPECT_EQ(run({"--set", expect, "--duration", "0.2"}), 0) << err_;
  EXPECT_EQ(out_.find("not as expected"), std::string::npos) << out_;
  EXPECT_NE(out_.find("note: expect is not checked"), std::string::npos) << out_;
  // The same, stated twice.
  EXPECT_EQ(run({"--set", expect, "--duration", "0.1"}), 0) << err_;
  EXPECT_NE(out_.find("not as expected"), std::string::npos) << out_;
  // A scene without a duration has that of the parameters.
  std::ofstream(path("scene.yaml")) << "{model: mass_spring, cloud: {shape: sheet, points: 100}, gravity: [0, 0, 0], "
                                       "simplification: {target_points: 40}, integrator: {time_step: 0.05}}";
  EXPECT_EQ(run({"--set", expect}), 0) << err_;
  EXPECT_NE(out_.find("not as expected"), std::string::npos) << out_;
  EXPECT_EQ(run({"--set", expect, "--duration", "0.1"}), 0) << err_;
  EXPECT_EQ(out_.find("not as expected"), std::string::npos) << out_;
}

TEST_F(Simulate, WhatIsNotAsExpectedFailsWithStrictOnly) {
  const std::vector<std::string> wrong{"--set", "expect={max_displacement: [1, 2]}"}, right{"--set", "expect={max_x: [0, 2]}"};
  const auto with = [](std::vector<std::string> arguments, const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  EXPECT_EQ(run(wrong), 0) << err_;
  EXPECT_EQ(run(with(right, {"--strict"})), 0) << err_;
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--strict"}, {"--strict", "--quiet"}}) {
    EXPECT_EQ(run(with(wrong, with(more, {"--final", path("end.ply")}))), 4) << out_;
    EXPECT_NE(err_.find("simulate: not as expected: expect.max_displacement"), std::string::npos) << err_;
    EXPECT_EQ(countFiles("end.ply"), 1);  // what was computed is written
  }
  EXPECT_EQ(run({"--strict"}), 2);
  EXPECT_NE(err_.find("found a scene without expect"), std::string::npos) << err_;
}

TEST_F(Simulate, GivesTheSameFilesForEveryNumberOfThreads) {
  for (const char* threads : {"1", "3"}) {
    const std::string n = threads;
    EXPECT_EQ(run({"--set", "gravity=[0, 0, -9.81]", "--threads", n, "--final", path(n + ".ply"), "--bag_out", path(n + ".bag")}),
              0);
  }
  EXPECT_EQ(readFile(path("1.ply")), readFile(path("3.ply")));
  EXPECT_EQ(readFile(path("1.bag")), readFile(path("3.bag")));
}

TEST_F(Simulate, TakesAwayFromItsCloudWhatTheSceneFilters) {
  const std::string crop = "input.filter.crop=[{box: {min: [-1, -1, -1], max: [0, 1, 1]}}]";
  EXPECT_EQ(run({"--set", crop, "--filtered", path("filtered.pcd"), "--final", path("final.pcd")}), 0) << err_;
  EXPECT_NE(out_.find("note: input.filter: taken away: crop 50; before: 100 points, "), std::string::npos) << out_;
  const cloud::PointCloud filtered = io::readPointFile(path("filtered.pcd"), 1.0, 1000);
  const cloud::PointCloud last = io::readPointFile(path("final.pcd"), 1.0, 1000);
  ASSERT_EQ(filtered.size(), 100);
  ASSERT_EQ(last.size(), 100);
  ASSERT_EQ(filtered.extra_fields.at(0).name, "removed_by");
  for (Index i = 0; i < 100; ++i) {
    const bool goes = filtered.positions[i].x() > 0.0;
    EXPECT_EQ(filtered.extra_fields[0].bytes[i], goes ? 1 : 0);
    EXPECT_EQ(last.positions[i].allFinite(), !goes);
  }
}

TEST_F(Simulate, SaysByWhichFilterAllPointsWentAndShowsIt) {
  EXPECT_EQ(run({"--set", "input.filter.plane.distance=0.01", "--filtered", path("filtered.ply")}), 2);
  EXPECT_EQ(err_,
            "simulate: input.filter: found 100 points, of which 0 stay (taken away: plane 100); accepted: filters that leave at "
            "least 3\n");
  EXPECT_TRUE(fs::exists(path("filtered.ply")));
  EXPECT_EQ(run({"--filtered", path("filtered.xyz")}), 2);
  EXPECT_EQ(run({"--filtered", path("none/filtered.ply")}), 2);
  EXPECT_NE(err_.find("--filtered: found "), std::string::npos) << err_;
  EXPECT_EQ(run({"--filtered", path("same.ply"), "--final", path("same.ply")}), 2);
}

TEST_F(Simulate, FiltersTheCloudsOfABagAlsoThoseToBeTracked) {
  writeBag("in.bag", [](rosbag::Bag& bag) {
    // One in another place, so that none of it is left.
    sensor_msgs::PointCloud2 other = makeCloud(ros::Time(kStart + 0.05));
    for (sensor_msgs::PointCloud2Iterator<float> x(other, "x"); x != x.end(); ++x) x[0] += 5.0f;
    bag.write("/deformable_surface/cloud_in", ros::Time(kStart + 0.05), other);
  });
  for (const char* policy : {"replace", "track"}) {
    EXPECT_EQ(
        run({"--bag_in", path("in.bag"), "--set", std::string("input.policy=") + policy, "--set", "input.filter.range.max=2.0"}),
        0)
        << err_;
    EXPECT_NE(out_.find("note: input.filter: taken away: none; before: 100 points"), std::string::npos) << out_;
    EXPECT_NE(err_.find("of which 0 stay (taken away: range 100)"), std::string::npos) << policy << ": " << err_;
  }
}

TEST_F(Simulate, WritesABagOfWhatTheNodeWouldPublish) {
  EXPECT_EQ(run({"--set", "frame_id=table", "--set", "output.publish_rate=20", "--bag_out", path("out.bag")}), 0);
  const rosbag::Bag bag(path("out.bag"));
  std::map<std::string, int> count;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    ++count[message.getTopic()];
    if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) {
      EXPECT_EQ(cloud->header.frame_id, "table");
    }
    if (const auto statistics = message.instantiate<Statistics>()) {
      EXPECT_NEAR(statistics->header.stamp.toSec(), statistics->simulation_time, 1e-9);
    }
  }
  EXPECT_EQ(count["/deformable_surface/deformed"], 3);
  EXPECT_EQ(count["/deformable_surface/simulation_points"], 3);
  EXPECT_EQ(count["/deformable_surface/markers"], 3);
  EXPECT_EQ(count["/deformable_surface/statistics"], 3);
  EXPECT_EQ(count["/deformable_surface/tool_wrenches"], 3);
  EXPECT_EQ(count["/deformable_surface/contacts"], 3);
}

}  // namespace
}  // namespace deformable_surface::node::test
