"""Running number of a camera's images, robust against single messages with a wrong one."""

from __future__ import annotations

CREDIBLE_JUMP = 64
"""Largest step, either way, between the numbers of two images that one message is believed."""


class ImageIndex:
    """Number that a camera's next image should have.

    A number far from it, such as after a restart of the camera, counts once a second message agrees: one wrong message
    would otherwise make all further images seem old.
    """

    def __init__(self) -> None:
        self.next: int | None = None
        """Number of the next image; None while it is not known."""
        self._outlier: int | None = None

    def take(self, index: int) -> bool:
        """Note the number of an image; return whether it is credible."""
        if index < 0 or not (self._is_near(index) or self._follows_outlier(index)):
            self._outlier = index
            return False
        is_near = self.next is not None and self._is_near(index)
        self.next = max(self.next, index + 1) if is_near and self.next is not None else index + 1
        self._outlier = None
        return True

    def take_count(self, images: int) -> None:
        """Note how many images the camera has taken; matters only where no message about one has told it."""
        if self.next is None:
            self.next = images
        elif not self._is_near(images):
            self.take(images - 1)

    def skip(self, index: int) -> None:
        """Expect the images after ``index``: that one was exposed and its message never came."""
        self.next = max(self.next or 0, index + 1)

    def _is_near(self, index: int) -> bool:
        return self.next is None or abs(index - self.next) <= CREDIBLE_JUMP

    def _follows_outlier(self, index: int) -> bool:
        return self._outlier is not None and 0 <= index - self._outlier <= CREDIBLE_JUMP
