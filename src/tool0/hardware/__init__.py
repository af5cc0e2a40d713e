"""The narrow waist: joint state in, joint effort out, once per step."""
