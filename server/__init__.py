"""The fleet service: REST, live stream and console (`python -m server`), guidance and the 3D scene."""
