# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Starts the controller manager with the robot of urdf/, and both controllers.

    ros2 launch servobus_ros2_control robot.launch.py port:=/dev/ttyUSB0
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.substitutions import Command, FindExecutable, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    package = FindPackageShare("servobus_ros2_control")
    model = PathJoinSubstitution([package, "urdf", "robot.urdf.xacro"])
    controllers = PathJoinSubstitution([package, "config", "controllers.yaml"])
    described = Command([FindExecutable(name="xacro"), " ", model, " port:=", LaunchConfiguration("port")])

    publisher = Node(package="robot_state_publisher", executable="robot_state_publisher",
                     parameters=[{"robot_description": ParameterValue(described, value_type=str)}])
    # Humble subscribes to ~/robot_description, Jazzy to robot_description.
    manager = Node(package="controller_manager", executable="ros2_control_node", output="both",
                   parameters=[controllers], remappings=[("~/robot_description", "/robot_description")])
    broadcaster = Node(package="controller_manager", executable="spawner", arguments=["joint_state_broadcaster"])
    driver = Node(package="controller_manager", executable="spawner", arguments=["diff_drive_controller"])
    return LaunchDescription([
        DeclareLaunchArgument("port", default_value="/dev/ttyUSB0", description="The serial port of the drive"),
        publisher,
        manager,
        broadcaster,
        RegisterEventHandler(OnProcessExit(target_action=broadcaster, on_exit=[driver])),
    ])
