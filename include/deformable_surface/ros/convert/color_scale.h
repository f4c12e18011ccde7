// The colours of strain and displacement: a calm neutral at rest, a perceptually even way to full scale. A file of its own
// because markers and their legend share it, and because it is colour science and no drawing.
#pragma once

#include <std_msgs/ColorRGBA.h>

namespace deformable_surface::node {

/// A light grey at 0 and below, a full orange at 1 and beyond, a muted blue for NaN. Equal steps of the value are equal distances
/// in CIELAB (CIE 1976), so that none seems larger than another.
std_msgs::ColorRGBA colorOf(double value);

}  // namespace deformable_surface::node
