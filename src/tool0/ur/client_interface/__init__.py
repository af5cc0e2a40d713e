"""UR's client interfaces: primary 30001, secondary 30002, real-time 30003."""
