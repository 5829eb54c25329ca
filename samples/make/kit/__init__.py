"""What the samples' scripts share: media, shapes, the studio, the exporter and its checks."""
