"""What is durable, behind functions that keep it consistent. Guidance and scene use them too."""
