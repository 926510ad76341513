"""The 3D scene: the lab as viser shows it, in a process of its own on loopback, reached through the server's /viser."""
