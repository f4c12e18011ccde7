// Reads a number from text. Hosts such as RViz set the locale of the user, in which strtod() may expect a comma.
#pragma once

namespace deformable_surface {

/// The number at the beginning of a text, as strtod() reads it in the locale "C". end: what is behind it; the text itself if it
/// begins with no number.
double readNumber(const char* text, const char** end);

}  // namespace deformable_surface
