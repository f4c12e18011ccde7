// The colours of strain and displacement: neutral at rest, perceptually uniform up to full scale. Markers and their legend share
// it.
#pragma once

#include <std_msgs/ColorRGBA.h>

namespace deformable_surface::node {

/// A light grey at 0 and below, a full orange at 1 and above, a muted blue for NaN. Equal steps of the value are equal distances
/// in CIELAB (CIE 1976), so that none looks larger than another.
std_msgs::ColorRGBA colorOf(double value);

/// Each 0 .. 1.
std_msgs::ColorRGBA makeColor(float r, float g, float b, float a = 1.0f);

}  // namespace deformable_surface::node
