#!/usr/bin/env python3
"""Three hosts, made of network namespaces: the master on one, the simulation on another, the commands on a third. The link of
each host is cut for a while and restored. Meanwhile the surface continues and a wrench without messages ends. Afterwards everything
works as before. Needs root and network namespaces that can be made and used; skipped (status 77) without."""
import json
import os
import subprocess
import sys
import threading
import time

HOSTS = {"master": "10.77.0.1", "simulation": "10.77.0.2", "commands": "10.77.0.3"}
PREFIX = "ds%d_" % os.getpid()
PATIENCE = 60.0  # s; only a check that fails takes that long
CUT = 4.0        # s
SKIPPED = 77
SCENE = """
model: mass_spring
material: {bending_rigidity: 0.01, damping: 20.0}
gravity: [0, 0, 0]
pins: [{box: {min: [-1, -1, -1], max: [-0.189, 1, 1]}}]
force: {radius: 0.03, timeout: 0.5}
"""


def run(*command):
    subprocess.run(command, check=True, stderr=subprocess.PIPE, universal_newlines=True)


def describe(error):
    """One line: the command that failed with its output, or the missing program."""
    if isinstance(error, subprocess.CalledProcessError):
        return "%s: %s" % (" ".join(error.cmd), " ".join(error.stderr.split()) or "status %d" % error.returncode)
    return str(error)


class Network:
    """The hosts and a switch, each in a namespace of its own, so that this machine is not changed."""

    def __enter__(self):
        try:
            self.build()
        except (OSError, subprocess.CalledProcessError) as error:
            # No program of this package has run yet: the machine does not support it.
            self.__exit__()
            print("skipped: network namespaces cannot be made and used here (%s)" % describe(error))
            sys.exit(SKIPPED)
        except BaseException:
            self.__exit__()
            raise
        return self

    def build(self):
        run("ip", "netns", "add", PREFIX + "switch")
        switch = ["ip", "-n", PREFIX + "switch", "link"]
        run(*switch, "add", "bridge", "type", "bridge")
        run(*switch, "set", "bridge", "up")
        for host, address in HOSTS.items():
            run("ip", "netns", "add", PREFIX + host)
            run(*switch, "add", "to_" + host, "type", "veth", "peer", "name", "net", "netns", PREFIX + host)
            run(*switch, "set", "to_" + host, "master", "bridge", "up")
            run("ip", "-n", PREFIX + host, "address", "add", address + "/24", "dev", "net")
            for name in ("lo", "net"):
                run("ip", "-n", PREFIX + host, "link", "set", name, "up")
            # In a chroot and in many containers namespaces can be made, but no program can enter them.
            run("ip", "netns", "exec", PREFIX + host, "true")

    def __exit__(self, *error):
        for host in ["switch"] + list(HOSTS):
            try:
                subprocess.run(["ip", "netns", "delete", PREFIX + host], stderr=subprocess.DEVNULL)
            except OSError:  # there is no ip
                return

    def link(self, host, state):
        run("ip", "-n", PREFIX + "switch", "link", "set", "to_" + host, state)


class Program:
    """A program on a host. It prints lines of JSON; the last line is kept."""

    def __init__(self, host, *command, reads=False):
        environment = dict(os.environ, ROS_MASTER_URI="http://%s:11311" % HOSTS["master"], ROS_IP=HOSTS[host])
        environment.pop("ROS_HOSTNAME", None)
        self.process = subprocess.Popen(("ip", "netns", "exec", PREFIX + host) + command, env=environment,
                                        stdout=subprocess.PIPE if reads else None, universal_newlines=True)
        self.last = {}
        if reads:
            threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            self.last = json.loads(line)

    def end(self):
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


def wait(what, condition):
    start = time.time()
    while not condition():
        if time.time() - start > PATIENCE:
            raise AssertionError("in %g s there was not: %s" % (PATIENCE, what))
        time.sleep(0.05)
    print("%s (after %.1f s)" % (what, time.time() - start), flush=True)


def check():
    programs = []
    with Network() as network:
        try:
            programs.append(Program("master", "roscore"))
            programs.append(Program("simulation", sys.executable, __file__, "load_and_run"))
            watch = Program("simulation", sys.executable, __file__, "watch", reads=True)
            commands = Program("commands", sys.executable, __file__, "command", reads=True)
            programs += [watch, commands]
            wait("the surface comes back to the host of the commands", lambda: commands.last.get("frames", 0) > 10)
            wait("the wrench bends it", lambda: watch.last.get("energy", 0) > 1e-6)
            time.sleep(2.0)  # until it is at rest so
            bent = watch.last["energy"]

            for host in ("commands", "master", "simulation"):
                network.link(host, "down")
                time.sleep(0.5)
                step, frames, start = watch.last["step"], commands.last["frames"], time.time()
                time.sleep(CUT)
                taken = (watch.last["step"] - step) / (time.time() - start)
                print("without the link of %s: %.0f steps per second" % (host, taken), flush=True)
                assert taken > 50, "the surface hardly moved on: %g steps per second of 100" % taken
                if host != "master":
                    # Half a second after the last wrench the force has ended.
                    assert watch.last["energy"] < 0.01 * bent, (watch.last, bent)
                    assert commands.last["frames"] <= frames + 5
                network.link(host, "up")
                frames = commands.last["frames"]
                wait("with it again, the surface comes to the commands", lambda: commands.last["frames"] > frames + 10)
                wait("and the wrench bends it", lambda: watch.last["energy"] > 0.5 * bent)
                calls = commands.last["calls"]
                wait("and services answer", lambda: commands.last["calls"] > calls)
            assert programs[1].process.poll() is None, "the node ended"
        finally:
            for program in reversed(programs):
                program.end()


def load_and_run():
    """The node with its parameters, on the host of the simulation."""
    import rosgraph
    import yaml
    while not rosgraph.is_master_online():
        time.sleep(0.1)
    rosgraph.Master("/load").setParam("/deformable_surface", yaml.safe_load(SCENE))
    os.execvp("rosrun", ["rosrun", "deformable_surface", "deformable_surface_node"])


def watch():
    import rosgraph
    import rospy
    from deformable_surface.msg import Statistics
    while not rosgraph.is_master_online():
        time.sleep(0.1)
    rospy.init_node("watch")
    rospy.Subscriber("/deformable_surface/statistics", Statistics, lambda m: print(
        json.dumps({"step": m.step, "energy": m.elastic_energy}), flush=True), queue_size=10)
    rospy.spin()


def command():
    """Sends a sheet once, then a wrench twenty times a second; calls a service once a second."""
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
    import numpy as np
    import rosgraph
    import rospy
    from deformable_surface.srv import SelectRegion
    from geometry_msgs.msg import WrenchStamped
    from scan_clouds import make_cloud
    from sensor_msgs.msg import PointCloud2
    while not rosgraph.is_master_online():
        time.sleep(0.1)
    rospy.init_node("command")
    counts = {"frames": 0, "calls": 0}
    cloud = rospy.Publisher("/deformable_surface/cloud_in", PointCloud2, queue_size=1, latch=True)
    wrench = rospy.Publisher("/deformable_surface/wrench", WrenchStamped, queue_size=1)

    def take(message):
        counts["frames"] += 1

    rospy.Subscriber("/deformable_surface/deformed", PointCloud2, take, queue_size=1)
    # Pinned at one end; the other is at the origin, where the wrench acts.
    grid = np.stack(np.meshgrid(0.01 * np.arange(-20, 1), 0.01 * np.arange(11), [0.0]), axis=-1).reshape(-1, 3)
    cloud.publish(make_cloud(grid, rospy.Time.now(), "world"))

    def call():
        while not rospy.is_shutdown():
            try:
                # Without a shape it is refused and changes nothing.
                rospy.ServiceProxy("/deformable_surface/unpin", SelectRegion)()
                counts["calls"] += 1
            except (rospy.ServiceException, rospy.ROSException, OSError):
                pass
            time.sleep(1.0)

    threading.Thread(target=call, daemon=True).start()
    message = WrenchStamped()
    message.header.frame_id = "world"
    message.wrench.force.z = 0.02
    while not rospy.is_shutdown():
        wrench.publish(message)
        print(json.dumps(counts), flush=True)
        time.sleep(0.05)


if __name__ == "__main__":
    {"load_and_run": load_and_run, "watch": watch, "command": command}.get(sys.argv[1] if len(sys.argv) > 1 else "", check)()
