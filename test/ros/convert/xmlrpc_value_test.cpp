// From the parameter server's values to the value tree.
#include "deformable_surface/ros/convert/xmlrpc_value.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <ctime>

namespace deformable_surface::node {
namespace {

TEST(XmlRpcValue, BecomesTheSameTree) {
  XmlRpc::XmlRpcValue value;
  value["model"] = "mass_spring";
  value["threads"] = 2;
  value["diagnostics"] = false;
  value["gravity"][0] = 0.0;
  value["gravity"][1] = 0;
  value["gravity"][2] = -9.81;
  value["integrator"]["time_step"] = 0.01;
  const Value tree = toValue(value);
  EXPECT_EQ(*tree.find("model")->asText(), "mass_spring");
  EXPECT_EQ(*tree.find("threads")->asInteger(), 2);
  EXPECT_FALSE(*tree.find("diagnostics")->asBool());
  const Value::List& gravity = *tree.find("gravity")->asList();
  ASSERT_EQ(gravity.size(), 3u);
  EXPECT_EQ(*gravity[0].asReal(), 0.0);
  EXPECT_EQ(*gravity[1].asInteger(), 0);
  EXPECT_EQ(*gravity[2].asReal(), -9.81);
  EXPECT_EQ(*tree.find("integrator")->find("time_step")->asReal(), 0.01);
  EXPECT_EQ(tree.asMap()->size(), 5u);
}

TEST(XmlRpcValue, KeepsEmptyMapsListsAndNothing) {
  EXPECT_TRUE(toValue(XmlRpc::XmlRpcValue()).isNull());
  XmlRpc::XmlRpcValue list, map;
  list.setSize(0);
  map.begin();  // makes it a map
  EXPECT_TRUE(toValue(list).asList()->empty());
  EXPECT_TRUE(toValue(map).asMap()->empty());
}

TEST(XmlRpcValue, RefusesDatesAndBinaryDataByKey) {
  std::tm date{};
  XmlRpc::XmlRpcValue value;
  value["pins"][0]["box"] = XmlRpc::XmlRpcValue(&date);
  try {
    toValue(value);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("pins[0].box"), std::string::npos) << error.what();
  }
  char bytes[] = "ab";
  EXPECT_THROW(toValue(XmlRpc::XmlRpcValue(bytes, 2)), InputError);
}

}  // namespace
}  // namespace deformable_surface::node
