"""Steps in flight: cameras at their own pace, commands of lines that fly on, and the conduct of sweeps and splits."""
