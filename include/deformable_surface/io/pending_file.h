// Writes files under a temporary name first, so that no reader sees half a file.
#pragma once

#include <string>

namespace deformable_surface::io {

/// The file that a name means: the end of its symbolic links, if it is one. That file need not exist. Throws InputError
/// for links that form a circle.
std::string followLinks(const std::string& file);

/// A name that a finished file gets. If the file is never finished, the temporary file is removed. A symbolic
/// link stays, and the file that it leads to is replaced.
class PendingFile {
 public:
  /// Throws InputError if the name is that of a folder or device.
  explicit PendingFile(const std::string& file);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::string& temporary() const { return temporary_; }
  /// Gives the file its name. Throws InputError.
  void keep();

 private:
  const std::string name_, file_, temporary_;  // as given, behind the links, in the same folder as the second
  bool kept_ = false;
};

}  // namespace deformable_surface::io
