"""Helpers of commands with their modules, for type checkers and ``lazy_loader``."""

from .scenes import read_scene as read_scene
from .scenes import read_scene_or_result_path as read_scene_or_result_path
from .sweeps import scene_and_keep_to_resume as scene_and_keep_to_resume
from .sweeps import sweep_decides_whole_boxes as sweep_decides_whole_boxes
from .terminal import print_json as print_json
from .terminal import print_json_or_files as print_json_or_files
from .terminal import print_note as print_note
from .terminal import print_note_if_loss_warning as print_note_if_loss_warning
from .terminal import print_notes as print_notes
from .terminal import print_result as print_result
from .terminal import print_sections as print_sections
from .terminal import print_written_files as print_written_files
from .terminal import progress as progress
