// Markers follow the rules by which RViz accepts them, and show the right content.
#include "deformable_surface/ros/convert/markers.h"

#include "deformable_surface/model/curved_triangles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace deformable_surface::node {
namespace {

using visualization_msgs::Marker;

bool isFinite(const geometry_msgs::Point& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

bool isColor(const std_msgs::ColorRGBA& color) {
  for (float part : {color.r, color.g, color.b, color.a})
    if (!(part >= 0.0f && part <= 1.0f)) return false;
  return true;
}

/// The first rule of RViz that a marker breaks, or nothing.
std::string checkMarker(const Marker& marker) {
  if (marker.action == Marker::DELETE) return "";
  if (marker.action != Marker::ADD) return "unknown action";
  const auto& q = marker.pose.orientation;
  if (std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) > 1e-6) return "orientation is not a unit quaternion";
  if (!isFinite(marker.pose.position)) return "position is not finite";
  if (!isColor(marker.color) || marker.color.a == 0.0f) return "colour is out of range or invisible";
  for (const auto& point : marker.points)
    if (!isFinite(point)) return "a point is not finite";
  for (const auto& color : marker.colors)
    if (!isColor(color)) return "a colour is out of range";
  if (!marker.colors.empty() && marker.colors.size() != marker.points.size()) return "colours and points differ in number";

  const auto isPositive = [](double size) { return size > 0.0 && std::isfinite(size); };
  const bool all_positive = isPositive(marker.scale.x) && isPositive(marker.scale.y) && isPositive(marker.scale.z);
  switch (marker.type) {
    case Marker::LINE_LIST:
      if (marker.points.empty() || marker.points.size() % 2 != 0) return "a line list without pairs of points";
      return isPositive(marker.scale.x) ? "" : "a line without width";
    case Marker::TRIANGLE_LIST:
      if (marker.points.empty() || marker.points.size() % 3 != 0) return "a triangle list without triples of points";
      return all_positive ? "" : "a scale that is not positive";
    case Marker::SPHERE:
    case Marker::CUBE:
    case Marker::CYLINDER: return all_positive ? "" : "a scale that is not positive";
    case Marker::SPHERE_LIST:
      if (marker.points.empty()) return "a sphere list without points";
      return all_positive ? "" : "a scale that is not positive";
    case Marker::ARROW:
      if (marker.points.size() != 2) return "an arrow without two points";
      return all_positive ? "" : "a scale that is not positive";
    case Marker::TEXT_VIEW_FACING:
      return marker.text.empty() || !isPositive(marker.scale.z) ? "a text without letters or height" : "";
    default: return "a type that is not expected";
  }
}

void expectValid(const visualization_msgs::MarkerArray& array) {
  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : array.markers) {
    EXPECT_EQ(checkMarker(marker), "") << marker.ns << ' ' << marker.id;
    EXPECT_TRUE(names.emplace(marker.ns, marker.id).second) << marker.ns << ' ' << marker.id << " occurs twice";
  }
}

std_msgs::Header makeHeader() {
  std_msgs::Header header;
  header.frame_id = "map";
  header.stamp.sec = 5;
  return header;
}

const Points kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
const std::vector<std::pair<Index, Index>> kLinks{{0, 1}, {1, 2}, {0, 2}};
const std::vector<model::WeightedTriangle> kTriangles{{{0, 1, 2}, 1.0}, {{0, 2, 3}, 1.0}};

TEST(Markers, DrawLinksWithTheColoursOfTheirEnds) {
  const Marker marker = makeLinksMarker(makeHeader(), "stretch_springs", kSquare, kLinks, {0.0, 0.05, 0.1, 0.0}, 0.1, 0.01);
  EXPECT_EQ(checkMarker(marker), "");
  EXPECT_EQ(marker.header.frame_id, "map");
  EXPECT_EQ(marker.header.stamp, ros::Time(5));
  EXPECT_EQ(marker.ns, "stretch_springs");
  EXPECT_EQ(marker.type, static_cast<int>(Marker::LINE_LIST));
  ASSERT_EQ(marker.points.size(), 6u);
  EXPECT_EQ(marker.points[3].y, 1.0);
  EXPECT_EQ(marker.colors[0], colorOf(0.0));
  EXPECT_EQ(marker.colors[1], colorOf(0.5));
  EXPECT_EQ(marker.colors[3], colorOf(1.0));
}

TEST(Markers, DrawTheSurfaceAndItsEdges) {
  const Marker surface = makeSurfaceMarker(makeHeader(), kSquare, kTriangles, {0, 0, 0, 1}, 1.0);
  EXPECT_EQ(checkMarker(surface), "");
  EXPECT_EQ(surface.points.size(), 6u);
  EXPECT_GT(surface.colors[5].r, 4.0f * surface.colors[5].b);  // orange, in any light
  const Marker wireframe = makeWireframeMarker(makeHeader(), kSquare, kLinks, 0.01);
  EXPECT_EQ(checkMarker(wireframe), "");
  EXPECT_EQ(wireframe.points.size(), 6u);
  EXPECT_TRUE(wireframe.colors.empty());
}

TEST(Markers, DrawABallAtEachPin) {
  const Marker marker = makePinsMarker(makeHeader(), kSquare, {0, 1, 0, 1}, 0.1);
  EXPECT_EQ(checkMarker(marker), "");
  ASSERT_EQ(marker.points.size(), 2u);
  EXPECT_EQ(marker.points[1].y, 1.0);
}

TEST(Markers, DeleteThemselvesWithNothingToShow) {
  EXPECT_EQ(makeLinksMarker(makeHeader(), "bending_springs", kSquare, {}, {0, 0, 0, 0}, 1.0, 0.01).action, int{Marker::DELETE});
  EXPECT_EQ(makeSurfaceMarker(makeHeader(), kSquare, {}, {0, 0, 0, 0}, 1.0).action, int{Marker::DELETE});
  EXPECT_EQ(makeWireframeMarker(makeHeader(), kSquare, {}, 0.01).action, int{Marker::DELETE});
  EXPECT_EQ(makePinsMarker(makeHeader(), kSquare, {0, 0, 0, 0}, 0.1).action, int{Marker::DELETE});
}

TEST(Markers, DrawForcesAsArrowsInProportion) {
  visualization_msgs::MarkerArray array;
  const int shown = addForceMarkers(makeHeader(), "forces", colorOf(1.0),
                                    {{Vec3(1, 0, 0), Vec3(0, 0, 4)}, {Vec3(2, 0, 0), Vec3(0, 2, 0)}}, 0.5, 0, array);
  EXPECT_EQ(shown, 2);
  ASSERT_EQ(array.markers.size(), 2u);
  expectValid(array);
  EXPECT_DOUBLE_EQ(array.markers[0].points[1].z, 0.5);
  EXPECT_DOUBLE_EQ(array.markers[1].points[0].x, 2.0);
  EXPECT_DOUBLE_EQ(array.markers[1].points[1].y, 0.25);
}

TEST(Markers, DeleteArrowsOfForcesThatEnded) {
  visualization_msgs::MarkerArray array;
  EXPECT_EQ(addForceMarkers(makeHeader(), "forces", colorOf(1.0), {{Vec3(1, 0, 0), Vec3(0, 0, 4)}}, 0.5, 3, array), 1);
  ASSERT_EQ(array.markers.size(), 3u);
  expectValid(array);
  EXPECT_EQ(array.markers[0].action, int{Marker::ADD});
  EXPECT_EQ(array.markers[1].action, int{Marker::DELETE});
  EXPECT_EQ(array.markers[2].action, int{Marker::DELETE});
}

TEST(Markers, DrawAZeroForceAsNothing) {
  visualization_msgs::MarkerArray array;
  addForceMarkers(makeHeader(), "forces", colorOf(1.0), {{Vec3(1, 0, 0), Vec3::Zero()}}, 0.5, 0, array);
  expectValid(array);
  EXPECT_EQ(array.markers[0].action, int{Marker::DELETE});
}

TEST(Markers, ShowABoundedNumberOfArrows) {
  visualization_msgs::MarkerArray array;
  const std::vector<std::pair<Vec3, Vec3>> forces(kMaxArrows + 50, {Vec3::Zero(), Vec3::UnitX()});
  EXPECT_EQ(addForceMarkers(makeHeader(), "forces", colorOf(1.0), forces, 0.5, 0, array), kMaxArrows);
  EXPECT_EQ(array.markers.size(), static_cast<std::size_t>(kMaxArrows));
}

TEST(Markers, DrawEveryToolThatActsWhereItIs) {
  using Kind = geometry::Solid::Kind;
  std::vector<tool::ToolParams> tools(5);
  for (int t = 0; t < 5; ++t) {
    tools[t].shape.kind = static_cast<Kind>(t);
    tools[t].path = {{0.0, Vec3(0, 0, t)}, {1.0, Vec3(2, 0, t)}};
  }
  tools[0].shape.radius = 0.3;
  tools[4].shape.normal = Vec3::UnitX();
  tools[4].shape.offset = 0.5;
  visualization_msgs::MarkerArray array;
  EXPECT_EQ(addToolMarkers(makeHeader(), tools, 0.5, 4.0, 0, array), 5);
  ASSERT_EQ(array.markers.size(), 5u);
  expectValid(array);
  const std::vector<int> types = {Marker::SPHERE, Marker::CUBE, Marker::CYLINDER, Marker::TRIANGLE_LIST, Marker::CUBE};
  for (int t = 0; t < 5; ++t) {
    EXPECT_EQ(array.markers[t].type, types[t]) << t;
    EXPECT_EQ(array.markers[t].pose.position.z, t) << t;
  }
  EXPECT_EQ(array.markers[0].scale.x, 0.6);
  EXPECT_EQ(array.markers[0].pose.position.x, 1.0);
  // The upper side of the plate is the plane: its offset along x from the origin of the tool.
  const Marker& plate = array.markers[4];
  EXPECT_NEAR(plate.pose.position.x + 0.5 * plate.scale.z, 1.5, 1e-12);
  EXPECT_NEAR(std::abs(plate.pose.orientation.y), std::sqrt(0.5), 1e-12);

  // One force has ended, one is removed.
  tools[1].end = 0.5;
  tools.pop_back();
  array.markers.clear();
  EXPECT_EQ(addToolMarkers(makeHeader(), tools, 0.5, 4.0, 5, array), 4);
  expectValid(array);
  EXPECT_EQ(array.markers[0].action, int{Marker::ADD});
  EXPECT_EQ(array.markers[1].action, int{Marker::DELETE});
  EXPECT_EQ(array.markers[4].action, int{Marker::DELETE});
}

TEST(Markers, GiveTheSurfaceLightFromAbove) {
  const Points roof{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<model::WeightedTriangle> floor{{{0, 1, 2}, 1.0}}, wall{{{0, 2, 3}, 1.0}}, turned{{{0, 2, 1}, 1.0}};
  const auto brightness = [&](const std::vector<model::WeightedTriangle>& triangles) {
    const Marker marker = makeSurfaceMarker(makeHeader(), roof, triangles, {0, 0, 0, 0}, 1.0);
    return marker.colors.front().b;
  };
  EXPECT_GT(brightness(floor), brightness(wall));
  EXPECT_GT(brightness(wall), 0.4f);
  EXPECT_EQ(brightness(turned), brightness(floor));
}

TEST(Markers, DrawPatchesNearerToASphereThanItsTriangles) {
  const Points corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<model::WeightedTriangle> triangles;
  for (const Index x : {0, 1})
    for (const Index y : {2, 3})
      for (const Index z : {4, 5}) triangles.push_back({{x, y, z}, 1.0});
  model::CurvedTriangles sphere = model::curveTriangles(corners, corners, triangles, 3);
  Orientations orientations;
  for (Vec3& p : sphere.positions) {
    p.normalize();
    orientations.push_back(Quaternion::FromTwoVectors(Vec3::UnitZ(), p));
  }
  const std::vector<double> values(sphere.positions.size(), 0.5);
  // The largest distance of the middle of a triangle from the sphere.
  const auto measure = [&](const Marker& marker) {
    EXPECT_EQ(checkMarker(marker), "");
    double farthest = 0.0;
    for (std::size_t i = 0; i + 2 < marker.points.size(); i += 3) {
      Vec3 middle = Vec3::Zero();
      for (std::size_t k = i; k < i + 3; ++k) middle += Vec3(marker.points[k].x, marker.points[k].y, marker.points[k].z) / 3.0;
      farthest = std::max(farthest, std::abs(middle.norm() - 1.0));
    }
    return farthest;
  };
  const Marker flat = makeSurfaceMarker(makeHeader(), sphere.positions, sphere.triangles, values, 1.0);
  const Marker patches = makePatchesMarker(makeHeader(), sphere.positions, orientations, sphere.triangles, values, 1.0, 5);
  EXPECT_EQ(patches.points.size(), 25u * flat.points.size());
  EXPECT_LT(measure(patches), 0.2 * measure(flat));
}

TEST(Markers, DrawParticlesAsDiscsAndAxes) {
  const Orientations orientations(4, Quaternion(Eigen::AngleAxisd(M_PI / 2.0, Vec3::UnitY())));  // normals along x
  const Marker discs = makeDiscsMarker(makeHeader(), kSquare, orientations, {0, 0, 0, 1}, 1.0, 0.25);
  EXPECT_EQ(checkMarker(discs), "");
  EXPECT_EQ(discs.points.size(), 4u * 18u);
  EXPECT_GT(discs.colors.back().r, 4.0f * discs.colors.back().b);  // orange, in any light
  for (std::size_t k = 0; k < 18; ++k) EXPECT_NEAR(discs.points[k].x, 0.0, 1e-12);
  const Marker axes = makeAxesMarker(makeHeader(), kSquare, orientations, 0.5, 0.01);
  EXPECT_EQ(checkMarker(axes), "");
  ASSERT_EQ(axes.points.size(), 4u * 6u);
  EXPECT_NEAR(axes.points[5].x, 0.5, 1e-12);  // the first one's normal
  EXPECT_EQ(axes.colors[5].b, 1.0f);
}

TextPlace makePlace() {
  TextPlace place;
  place.anchor = Vec3(1, 2, 3);
  place.height = 0.1;
  return place;
}

TEST(Markers, TellWhatTheLastStepDid) {
  simulation::Statistics statistics;
  statistics.simulation_time = 1.5;
  statistics.simulation_points = 300;
  statistics.points = 4000;
  const Marker marker = makeStatisticsMarker(makeHeader(), statistics, makePlace());
  EXPECT_EQ(checkMarker(marker), "");
  EXPECT_EQ(marker.pose.position.z, 3.0);
  EXPECT_NE(marker.text.find("1.50 s"), std::string::npos) << marker.text;
  EXPECT_NE(marker.text.find("300 of 4000 points"), std::string::npos) << marker.text;
  EXPECT_EQ(marker.text.find("error"), std::string::npos) << marker.text;  // there is no estimate
  statistics.error_estimate = 0.002;
  statistics.error_bounded = true;
  const std::string calm = makeStatisticsMarker(makeHeader(), statistics, makePlace()).text;
  EXPECT_NE(calm.find("error 2.00 mm"), std::string::npos) << calm;
  EXPECT_EQ(calm.find("buckle"), std::string::npos) << calm;
  statistics.may_buckle = true;
  const std::string pressed = makeStatisticsMarker(makeHeader(), statistics, makePlace()).text;
  EXPECT_NE(pressed.find("error 2.00 mm, may buckle"), std::string::npos) << pressed;
  statistics.error_bounded = false;
  const std::string dented = makeStatisticsMarker(makeHeader(), statistics, makePlace()).text;
  EXPECT_NE(dented.find("error 2.00 mm, no bound, may buckle"), std::string::npos) << dented;
}

TEST(Markers, ExplainTheColoursInThem) {
  visualization_msgs::MarkerArray array;
  addLegendMarkers(makeHeader(), "strain_legend", "strain", "%", 10.0, makePlace(), array);
  expectValid(array);
  std::map<std::string, std_msgs::ColorRGBA> colors;
  for (const Marker& marker : array.markers) {
    const std::size_t begin = marker.text.find_first_not_of(" \n");
    colors[marker.text.substr(begin, marker.text.find_last_not_of(" \n") + 1 - begin)] = marker.color;
  }
  EXPECT_EQ(colors.count("strain"), 1u);
  EXPECT_EQ(colors.at("0 %"), colorOf(0.0));
  EXPECT_EQ(colors.at("5 %"), colorOf(0.5));
  EXPECT_EQ(colors.at("10 %"), colorOf(1.0));
}

/// The rows of a text in which something stands, of so many that RViz centres on its position.
std::set<int> rowsOf(const Marker& marker) {
  std::set<int> rows;
  int row = 0;
  for (const char letter : marker.text) {
    if (letter == '\n') {
      ++row;
    } else {
      rows.insert(row);
    }
  }
  EXPECT_EQ(row + 1, 2 * kRowsAbove) << marker.text;
  return rows;
}

TEST(Markers, LeaveNoTextOnAnotherNorOnTheButtonBetweenThem) {
  visualization_msgs::MarkerArray array;
  addLegendMarkers(makeHeader(), "strain_legend", "strain", "%", 10.0, makePlace(), array);
  std::set<int> legend;
  for (const Marker& marker : array.markers)
    for (const int row : rowsOf(marker)) legend.insert(row);
  simulation::Statistics statistics;
  statistics.error_estimate = 0.002;
  statistics.may_buckle = true;
  const std::set<int> told = rowsOf(makeStatisticsMarker(makeHeader(), statistics, makePlace()));
  std::string sentence;
  for (int words = 0; words < 100; ++words) {
    Marker answer;
    answer.text = showBelow(sentence);
    const std::set<int> rows = rowsOf(answer);
    if (!rows.empty()) {
      EXPECT_GT(*rows.begin(), kRowsAbove);
    }
    EXPECT_LT(rows.size(), static_cast<std::size_t>(kRowsBelow));
    sentence += sentence.empty() ? "word" : " word";
  }
  EXPECT_LT(*legend.rbegin(), *told.begin());
  EXPECT_LT(*told.rbegin(), kRowsAbove - 1);
}

TEST(SimulationMarkers, FollowParticlesThatAreBornAndGo) {
  cloud::PointCloud input;
  for (int i = 0; i < 100; ++i) input.positions.emplace_back(0.1 * (i % 10) + 0.05 * (i / 10 % 2), 0.087 * (i / 10), 0.0);
  input.width = 100;
  simulation::SceneParams params;
  params.model = "oriented_particles";
  params.gravity.setZero();
  simulation::Simulation simulation(params, input);
  SimulationMarkers markers(simulation, "map");
  visualization_msgs::MarkerArray array;
  const auto countDiscs = [&] {
    markers.make(makeHeader(), simulation, array);
    expectValid(array);
    for (const Marker& marker : array.markers)
      if (marker.ns == "discs" && marker.action == Marker::ADD) return static_cast<Index>(marker.points.size() / 18);
    return Index{0};
  };
  EXPECT_EQ(countDiscs(), simulation.state().size());
  const Index before = simulation.state().size();
  tool::ToolParams eraser;
  eraser.id = "eraser";
  eraser.mode = tool::Mode::kErase;
  eraser.shape.radius = 0.15;
  eraser.path = {{0.0, Vec3(0.1, 0.1, 0.0)}};
  simulation.setTool(eraser);
  ASSERT_TRUE(simulation.step().ok);
  EXPECT_LT(simulation.state().size(), before);
  EXPECT_EQ(countDiscs(), simulation.state().size());
  // The remaining points are at their places: none is measured from the place of another.
  for (const Marker& marker : array.markers) {
    if (marker.ns != "surface") continue;
    EXPECT_FALSE(marker.colors.empty());
    for (const auto& color : marker.colors) EXPECT_LT(std::abs(color.r - color.b), 0.1f);  // neutral, in any light
  }
  eraser.shape.radius = 10.0;
  simulation.setTool(eraser);
  ASSERT_TRUE(simulation.step().ok);
  EXPECT_EQ(simulation.state().size(), 0);
  EXPECT_EQ(countDiscs(), 0);
}

TEST(SimulationMarkers, DrawPatchesWithTheSameBitsForAnyNumberOfThreads) {
  cloud::PointCloud input;
  for (int i = 0; i < 100; ++i) {
    const double x = 0.1 * (i % 10), y = 0.1 * (i / 10);
    input.positions.emplace_back(x, y, 0.2 * std::sin(3.0 * x));
  }
  input.width = 100;
  const auto draw = [&](int threads, Index pieces) {
    simulation::SceneParams params;
    params.model = "oriented_particles";
    params.threads = threads;
    params.output.pieces_per_edge = pieces;
    simulation::Simulation simulation(params, input);
    SimulationMarkers markers(simulation, "map");
    EXPECT_TRUE(simulation.step().ok);
    visualization_msgs::MarkerArray array;
    markers.make(makeHeader(), simulation, array);
    expectValid(array);
    for (const Marker& marker : array.markers)
      if (marker.ns == "surface") return marker;
    return Marker();
  };
  const Marker flat = draw(1, 1), one = draw(1, 4), three = draw(3, 4);
  EXPECT_EQ(one.points.size(), 16u * flat.points.size());
  EXPECT_TRUE(one.points == three.points);
  EXPECT_TRUE(one.colors == three.colors);
}

TEST(SimulationMarkers, ShowASimulationInEveryNamespaceAndKeepTheRules) {
  cloud::PointCloud input;
  for (int i = 0; i < 100; ++i) input.positions.emplace_back(0.1 * (i % 10), 0.1 * (i / 10), 0.0);
  input.width = 100;
  simulation::SceneParams params;
  params.pins.emplace_back();
  params.pins.back().region.min = Vec3(-0.05, -0.05, -0.05);
  params.pins.back().region.max = Vec3(0.05, 0.95, 0.05);
  simulation::Simulation simulation(params, input);
  SimulationMarkers markers(simulation, "map");
  visualization_msgs::MarkerArray array;
  std::map<std::string, int> actions;
  const auto make = [&] {
    markers.make(makeHeader(), simulation, array);
    expectValid(array);
    for (const Marker& marker : array.markers) actions[marker.ns] = marker.action;
  };
  make();
  for (const char* ns : {"stretch_springs", "surface", "wireframe", "pins"}) EXPECT_EQ(actions.at(ns), int{Marker::ADD}) << ns;
  EXPECT_EQ(actions.count("bending_springs"), 1u);
  EXPECT_EQ(actions.count("forces"), 0u);

  simulation::ForceParams force;
  force.id = "pull";
  force.point = Vec3(0.9, 0.9, 0.0);
  force.force = Vec3(0.0, 0.0, 0.1);
  simulation.setForce(force);
  ASSERT_TRUE(simulation.step().ok);
  make();
  EXPECT_EQ(actions.at("forces"), int{Marker::ADD});
  EXPECT_EQ(actions.at("statistics"), int{Marker::ADD});
  EXPECT_EQ(actions.count("contacts"), 0u);

  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.2;
  ball.path = {{0.0, Vec3(0.5, 0.5, -0.15)}};
  simulation.setTool(ball);
  make();
  EXPECT_EQ(actions.at("tools"), int{Marker::ADD});
  EXPECT_EQ(actions.at("contacts"), int{Marker::ADD});
  EXPECT_EQ(actions.at("contact_points"), int{Marker::ADD});

  simulation.reset();
  make();
  EXPECT_EQ(actions.at("forces"), int{Marker::DELETE});
}

TEST(Markers, ContactsAreLinesAlongTheirForcesTheLargestOfTheLengthAskedFor) {
  std_msgs::Header header;
  const Marker none = makeContactsMarker(header, {}, 0.1, 0.01);
  EXPECT_EQ(none.action, int{Marker::DELETE});
  const Marker marker = makeContactsMarker(header, {{Vec3(1, 0, 0), Vec3(0, 0, 4)}, {Vec3(0, 1, 0), Vec3(0, 2, 0)}}, 0.1, 0.01);
  ASSERT_EQ(marker.points.size(), 4u);
  EXPECT_EQ(marker.points[0].x, 1.0);
  EXPECT_NEAR(marker.points[1].z, 0.1, 1e-15);
  EXPECT_NEAR(marker.points[3].y, 1.05, 1e-15);
}

}  // namespace
}  // namespace deformable_surface::node
