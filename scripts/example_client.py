#!/usr/bin/env python3
"""A client of one page: sends a sheet, pins one edge, pulls at the other, prints how high it came. Run it beside
"roslaunch deformable_surface deformable_surface.launch" and take from it what you need."""
import numpy as np
import rospy
from deformable_surface.msg import PointForce, Statistics
from deformable_surface.srv import SelectRegion, SelectRegionRequest
from geometry_msgs.msg import Point, Vector3
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Header
from std_srvs.srv import SetBool

SURFACE = "/deformable_surface/"

rospy.init_node("example_client")
cloud = rospy.Publisher(SURFACE + "cloud_in", PointCloud2, queue_size=1, latch=True)
force = rospy.Publisher(SURFACE + "force", PointForce, queue_size=1, latch=True)
pause = rospy.ServiceProxy(SURFACE + "pause", SetBool)
pin = rospy.ServiceProxy(SURFACE + "pin", SelectRegion)
pause.wait_for_service()

# A sheet of 0.4 m by 0.2 m in z = 0, at rest. Paused, so that it does not fall before it is pinned.
pause(True)
x, y = np.meshgrid(np.linspace(0.0, 0.4, 41), np.linspace(0.0, 0.2, 21))
points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
cloud.publish(point_cloud2.create_cloud_xyz32(Header(stamp=rospy.Time.now(), frame_id="world"), points))
rospy.wait_for_message(SURFACE + "deformed", PointCloud2, timeout=30)  # s; if it ends, the node's log says why the cloud was refused

edge = SelectRegionRequest(primitive=SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.02, 1.0, 0.02]))  # about the origin
edge.pose.orientation.w = 1.0
response = pin(edge)
print(response.message)

# 1 N upwards, more than the sheet weighs (0.8 N), shared among the points within 3 cm of the free edge's middle.
force.publish(PointForce(id="pull", point=Point(0.4, 0.1, 0.0), force=Vector3(0.0, 0.0, 1.0), radius=0.03))
last = {}
rospy.Subscriber(SURFACE + "deformed", PointCloud2, lambda message: last.update(surface=message), queue_size=1)
rospy.Subscriber(SURFACE + "statistics", Statistics, lambda message: last.update(statistics=message), queue_size=1)
pause(False)
for _ in range(5):
    rospy.sleep(0.3)
    if len(last) < 2:
        continue
    height = [row[0] for row in point_cloud2.read_points(last["surface"], ["z"], skip_nans=True)]
    print("after %.2f s: up to %.1f mm above where it lay, stretched by up to %.2f %%" %
          (last["statistics"].simulation_time, 1000 * max(height), 100 * last["statistics"].max_stretch))
