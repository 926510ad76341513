"""From camera frames to poses in the map frame (spec localization).

In process: `pipeline.CameraPipeline` turns frames into detections, `tracking.Tracker` detections into poses. As processes:
`python -m localization.camera CAMERA` and `python -m localization.tracker`. Single pictures: `images.detect_image`.
"""
