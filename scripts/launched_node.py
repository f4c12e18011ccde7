#!/usr/bin/env python3
"""Ends a node in Python: at once on Ctrl-C, and without an error when a launch has done its work. Several nodes of the launch files
use it."""
import functools
import os
import signal
import sys
import xmlrpc.client

import rospy


def run_node(name, main):
    """Runs main() as the node and exits the process. A sentence that it returns is logged as the reason why it failed. Python's
    own handler of Ctrl-C interrupts main() wherever it is; rospy's only sets a flag."""
    problem = None
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rospy.init_node(name, disable_signals=True)
        problem = main()
    except (KeyboardInterrupt, rospy.ROSInterruptException):
        pass
    if problem:
        rospy.logfatal("%s: %s", name, problem)
    rospy.signal_shutdown("done")
    sys.exit(1 if problem else 0)


def until_shutdown(callback):
    """The callback of a timer or subscriber that publishes. One that runs while the node ends finds its topics closed."""
    @functools.wraps(callback)
    def call(*arguments):
        try:
            callback(*arguments)
        except rospy.ROSException:
            if not rospy.core.is_shutdown_requested():  # topics are closed before is_shutdown() says so
                raise
    return call


def find_launch():
    """The roslaunch that started this node, as a proxy of its XML-RPC interface. None if there is none."""
    for uri in rospy.get_param("/roslaunch/uris", {}).values():
        launch = xmlrpc.client.ServerProxy(uri)
        try:
            if launch.get_pid()[2] == os.getppid():
                return launch
        except OSError:  # a launch that was killed is still listed
            pass
    return None


def end_neighbor(name):
    """Ends another node of this launch, as Ctrl-C does. Returns whether there was one of that name."""
    launch = find_launch()
    for process, _ in launch.list_processes()[2][0] if launch else []:
        if process.rpartition("-")[0] == name:  # roslaunch appends a number
            os.kill(launch.process_info(process)[2]["pid"], signal.SIGINT)
            return True
    return False


def end_launch():
    """Ends the launch that started this node, as Ctrl-C does, and waits until it does. The attribute `required` ends it too, but
    calls that an error. Without a launch it does nothing."""
    if find_launch():
        os.kill(os.getppid(), signal.SIGINT)
        rospy.spin()
