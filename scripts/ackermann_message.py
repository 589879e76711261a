"""ackermann_msgs/AckermannDriveStamped, also where that package is not installed (Debian has none): same definition, same
checksum, so both ends understand each other."""
try:
    from ackermann_msgs.msg import AckermannDriveStamped
except ImportError:
    from genpy.dynamic import generate_dynamic

    DEFINITION = """Header header
AckermannDrive drive
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: ackermann_msgs/AckermannDrive
float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
"""
    AckermannDriveStamped = generate_dynamic("ackermann_msgs/AckermannDriveStamped", DEFINITION)[
        "ackermann_msgs/AckermannDriveStamped"]

__all__ = ["AckermannDriveStamped"]
