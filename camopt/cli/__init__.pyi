"""What commands use besides public names, each with its module: type checkers and ``lazy_loader`` read them."""

from .scenes import scene_at as scene_at
from .scenes import shown_at as shown_at
from .sweeps import is_by_boxes as is_by_boxes
from .sweeps import unfinished_sweep as unfinished_sweep
from .terminal import print_files as print_files
from .terminal import print_json as print_json
from .terminal import print_result as print_result
from .terminal import progress as progress
from .terminal import say_lost as say_lost
from .terminal import say_note as say_note
from .terminal import say_notes as say_notes
from .terminal import say_written as say_written
from .terminal import show as show
