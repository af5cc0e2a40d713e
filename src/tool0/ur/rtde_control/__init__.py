"""The control program of ur_rtde, served natively."""
