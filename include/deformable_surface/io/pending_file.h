// How every file is written: under a temporary name first, so that nobody meets half of one.
#pragma once

#include <string>

namespace deformable_surface::io {

/// The file that a name stands for: where its symbolic links end, if it is one; that file need not be there. Throws InputError
/// for links that go round in a circle.
std::string followLinks(const std::string& file);

/// A name that a finished file gets; what was written before under the temporary name is removed if it never does. A symbolic
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
