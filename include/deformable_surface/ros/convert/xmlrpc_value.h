// Converts values of the parameter server to the value tree that the reader of parameters takes.
#pragma once

#include "deformable_surface/base/value.h"

#include <xmlrpcpp/XmlRpcValue.h>

namespace deformable_surface::node {

/// Keys come in alphabetical order, since the parameter server keeps no other. Throws InputError, naming the dotted key, for
/// dates and binary data: no parameter is one.
Value toValue(const XmlRpc::XmlRpcValue& value);

}  // namespace deformable_surface::node
