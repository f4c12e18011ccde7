// Reads an XmlRpcValue. No other file uses XmlRpc's types.
#include "deformable_surface/ros/convert/xmlrpc_value.h"

#include "deformable_surface/base/error.h"

#include <string>

namespace deformable_surface::node {
namespace {

Value convert(const XmlRpc::XmlRpcValue& value, const std::string& path) {
  using XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case XmlRpcValue::TypeInvalid: return Value();
    case XmlRpcValue::TypeBoolean: return Value(static_cast<const bool&>(value));
    case XmlRpcValue::TypeInt: return Value(static_cast<const int&>(value));
    case XmlRpcValue::TypeDouble: return Value(static_cast<const double&>(value));
    case XmlRpcValue::TypeString: return Value(static_cast<const std::string&>(value));
    case XmlRpcValue::TypeArray: {
      Value::List list;
      for (int i = 0; i < value.size(); ++i) list.push_back(convert(value[i], path + "[" + std::to_string(i) + "]"));
      return Value(std::move(list));
    }
    case XmlRpcValue::TypeStruct: {
      Value::Map map;
      for (const auto& [key, member] : value) map.emplace_back(key, convert(member, path.empty() ? key : path + "." + key));
      return Value(std::move(map));
    }
    case XmlRpcValue::TypeDateTime:
    case XmlRpcValue::TypeBase64: break;
  }
  throw InputError("parameter " + quote(path) +
                   " is a date or binary data; accepted are numbers, texts, booleans, lists and maps");
}

}  // namespace

Value toValue(const XmlRpc::XmlRpcValue& value) { return convert(value, ""); }

}  // namespace deformable_surface::node
