// Objects before the depth camera of camera_frames.h: towels, blankets and a garment, in metres, seen from a distance along the
// camera's axis. Each has places where it is held and pulled, so that the surface built from a frame can be simulated.
#pragma once

#include "camera_frames.h"

#include <string>
#include <vector>

namespace deformable_surface::test {

struct CameraScene {
  std::string name;
  std::vector<Sheet> sheets;
  Vec2 field;              // m across at that distance: what of the picture matters
  std::vector<Vec3> held;  // centres of balls; every piece of the true surface that is seen has some
  Vec3 pulled, direction;  // centre of a ball and away from what it lies on, unit
  double distance = 1.0;   // m
};

constexpr double kHeldRadius = 0.02;  // m, of those balls

CameraScene makeTowel(double distance, double tilt_degrees);
/// Turned over about a line; gap: m, between the flap and what is below.
CameraScene makeFoldedTowel(double distance, double gap, double tilt_degrees = 0.0);
CameraScene makeCornerFold(double distance, double gap);
/// height: m, of the blanket over the table; waves: m, of its wrinkles.
CameraScene makeBlanket(double distance, double height, double waves);
/// A small T-shirt a few millimetres to a centimetre over a table; its sleeves hang beside the body.
CameraScene makeGarment(double distance);
/// One of them covers the left half of the other.
CameraScene makeTwoSheets(double distance, double gap);

/// All of them, with sheets 5, 10 and 20 mm apart.
std::vector<CameraScene> makeCameraScenes(double distance);

/// A camera that sees the field of the scene and nothing more, otherwise as given.
DepthCamera aimAt(const CameraScene& scene, DepthCamera camera);

}  // namespace deformable_surface::test
