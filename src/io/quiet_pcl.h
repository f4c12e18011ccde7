// PCL writes its complaints to the console; ours are exceptions.
#pragma once

#include <pcl/console/print.h>

#include <mutex>

namespace deformable_surface::io {

/// PCL is silent in this process while such objects live. Afterwards it writes what it wrote before: it may serve other nodelets.
class QuietPcl {
 public:
  QuietPcl() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (count_++ > 0) return;
    before_ = pcl::console::getVerbosityLevel();
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~QuietPcl() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--count_ == 0) pcl::console::setVerbosityLevel(before_);
  }
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

 private:
  static inline std::mutex mutex_;
  static inline int count_ = 0;
  static inline pcl::console::VERBOSITY_LEVEL before_ = pcl::console::L_INFO;
};

}  // namespace deformable_surface::io
