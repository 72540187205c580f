!> The file that keeps the finished pieces of long work, from which a rerun continues; or the files
!> of several parts of the work.
!>
!> The first line identifies the work by a checksum of all its input. Each piece (a surface, a
!> position) follows in order: a line with its number, its number of words of 64 bits and their
!> checksum, and a line with the words, 16 hexadecimal digits each. A record is appended by one
!> write. A record that was interrupted fails its checksum and is removed by the next run.
module asperity_kept_records
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_null_char
  use asperity_files, only: read_whole_file, write_bytes
  use asperity_kinds, only: int64
  use asperity_printable, only: printable_text
  use asperity_problems, only: decimal_text
  use asperity_output_files, only: commit_files, stage_file, note_kept
  use asperity_system_calls, only: posix_close, posix_fsync, posix_lseek, posix_open, &
                                   system_error, system_reason
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: checksum, join_records, keep_records, kept_file, kept_work, pieces_of_part, &
            resume_records, whole_number, word_record

  !> A file of kept work.
  type :: kept_file
    character(len=:), allocatable :: path      !! path as the user gave it
  end type kept_file

  !> Work and its file. Part I of N of the work consists of its pieces I, I + N, I + 2 N and so on;
  !> in its file they are numbered from 1.
  type :: kept_work
    character(len=:), allocatable :: path      !! path of the file
    integer :: part = 1                        !! number of the part that is done, from 1
    integer :: parts = 1                       !! number of parts
    type(kept_file), allocatable :: more(:)    !! files of further parts, to be combined
    character(len=:), allocatable :: heading   !! first line, which identifies the work
    character(len=:), allocatable :: piece     !! name of a piece, for instance `surface`
    character(len=:), allocatable :: of_what   !! name of the input: `this specification`
  end type kept_work

  !> The result of a piece of work, in words of 64 bits; not allocated: none.
  type :: word_record
    integer(int64), allocatable :: words(:)
  end type word_record

  ! O_RDONLY with O_NONBLOCK, and O_WRONLY with O_APPEND and O_NONBLOCK, of Linux: without
  ! O_NONBLOCK the open of a pipe blocks until its other end is open.
  integer(c_int), parameter :: read_only = 2048_c_int, append = 3073_c_int, no_such_file = 2_c_int
  integer(c_int), parameter :: from_start = 0_c_int
  integer, parameter :: word_digits = 16

contains

  !> Reads the records of an earlier run and prepares the file for more. `failure` is allocated when
  !> the file belongs to other work or cannot be read or written.
  subroutine resume_records(work, most, records, failure)
    type(kept_work), intent(in) :: work                        !! work; its file need not exist
    integer, intent(in) :: most                                !! number of all pieces
    type(word_record), allocatable, intent(out) :: records(:)  !! kept records, from the first
    character(len=:), allocatable, intent(out) :: failure      !! reason, when there are none
    character(len=:), allocatable :: text, heading
    integer(c_int) :: descriptor, status
    integer :: used

    allocate (records(0))
    heading = work%heading // part_text(work%part, work%parts) // new_line('a')
    text = ''
    descriptor = posix_open(work%path // c_null_char, read_only)
    if (descriptor >= 0) then
      if (posix_lseek(descriptor, 0_c_long, from_start) < 0_c_long) &
        failure = work%path // ': is a pipe or a terminal, expected a file for what is kept'
      status = posix_close(descriptor)
      if (.not. allocated(failure)) call read_whole_file(work%path, text, failure)
    else if (system_error() /= no_such_file) then
      failure = work%path // ': cannot be opened: ' // system_reason()
    end if
    if (allocated(failure)) return
    used = 0
    if (len(text) > 0) then
      used = min(len(heading), len(text))
      if (text(:used) /= heading(:used)) then
        failure = work%path // ': holds no ' // work%piece // 's of ' // work%of_what // &
                  ', expected a file that a run with the same text kept, or none'
        return
      end if
      if (used < len(heading)) used = 0
    end if
    if (used > 0) call take_records(text, work%piece, most, used, records)
    call note_progress(work, size(records))
    if (used == len(text) .and. used > 0) return
    ! The file is new, or its last record is incomplete.
    if (used > 0) heading = text(:used)
    call stage_file(work%path, heading, failure)
    if (.not. allocated(failure)) call commit_files(failure)
  end subroutine resume_records

  !> Number of pieces of a part of the work.
  elemental integer function pieces_of_part(pieces, part, parts) result(number)
    integer, intent(in) :: pieces  !! number of all pieces
    integer, intent(in) :: part    !! number of the part, from 1
    integer, intent(in) :: parts   !! number of all parts

    number = (pieces - part + parts) / parts
  end function pieces_of_part

  !> Number in the whole work of a piece of a part.
  elemental integer function whole_number(piece, part, parts) result(number)
    integer, intent(in) :: piece   !! number in the part
    integer, intent(in) :: part    !! number of the part, from 1
    integer, intent(in) :: parts   !! number of all parts

    number = part + (piece - 1) * parts
  end function whole_number

  !> Combines the records of all parts, in the order of the whole work. `failure` is allocated when
  !> a file is not one of the parts, or when a part is missing or incomplete.
  subroutine join_records(work, total, records, failure)
    type(kept_work), intent(in) :: work                        !! work with `more` files
    integer, intent(in) :: total                               !! number of all pieces
    type(word_record), allocatable, intent(out) :: records(:)  !! records of all pieces
    character(len=:), allocatable, intent(out) :: failure      !! reason, when they are incomplete
    character(len=:), allocatable :: path
    logical, allocatable :: is_there(:)
    integer :: i, parts

    parts = 1 + size(work%more)
    allocate (records(total), is_there(parts))
    is_there = .false.
    do i = 1, parts
      if (i == 1) then
        path = work%path
      else
        path = work%more(i - 1)%path
      end if
      call join_part(work, path, is_there, records, failure)
      if (allocated(failure)) return
    end do
  end subroutine join_records

  ! Adds the records of one part.
  subroutine join_part(work, path, is_there, records, failure)
    type(kept_work), intent(in) :: work
    character(len=*), intent(in) :: path
    logical, intent(inout) :: is_there(:)
    type(word_record), intent(inout) :: records(:)
    character(len=:), allocatable, intent(out) :: failure
    type(word_record), allocatable :: found(:)
    character(len=:), allocatable :: heading, text
    integer :: i, part, parts, pieces, used

    call read_whole_file(path, text, failure)
    if (allocated(failure)) return
    parts = size(is_there)
    do part = 1, parts
      heading = work%heading // part_text(part, parts) // new_line('a')
      if (index(text, heading) == 1) exit
    end do
    if (part > parts) then
      failure = path // ': holds no part of ' // decimal_text(parts) // ' of the ' // &
                work%piece // 's of ' // work%of_what // ', expected the files of all ' // &
                decimal_text(parts) // ' parts that --share kept, each with one --keep'
      return
    end if
    if (is_there(part)) then
      failure = path // ': holds part ' // decimal_text(part) // ' of ' // decimal_text(parts) // &
                ' once more, expected each part once'
      return
    end if
    is_there(part) = .true.
    pieces = pieces_of_part(size(records), part, parts)
    used = len(heading)
    allocate (found(0))
    call take_records(text, work%piece, pieces, used, found)
    if (size(found) < pieces) then
      failure = path // ': holds ' // decimal_text(size(found)) // ' of ' // &
                decimal_text(pieces) // ' ' // work%piece // 's, expected all: run it with ' // &
                '--share ' // decimal_text(part) // '/' // decimal_text(parts) // ' to its end'
      return
    end if
    do i = 1, pieces
      call move_alloc(found(i)%words, records(whole_number(i, part, parts))%words)
    end do
  end subroutine join_part

  ! Text of the part in the first line; empty for the whole work.
  pure function part_text(part, parts) result(text)
    integer, intent(in) :: part, parts
    character(len=:), allocatable :: text

    text = ''
    if (parts > 1) text = ', part ' // decimal_text(part) // ' of ' // decimal_text(parts)
  end function part_text

  !> Appends records to the file. `failure` is allocated when they cannot be written.
  subroutine keep_records(work, first, records, failure)
    type(kept_work), intent(in) :: work                    !! work of resume_records
    integer, intent(in) :: first                           !! number of the first record
    type(word_record), intent(in) :: records(:)            !! records in their order
    character(len=:), allocatable, intent(out) :: failure  !! reason, when they cannot be written
    type(text_buffer) :: text
    character(len=:), allocatable :: body
    integer(c_int) :: descriptor, status
    integer :: i

    do i = 1, size(records)
      body = hexadecimal_text(records(i)%words)
      call text%append(heading_of(work%piece, first + i - 1, body))
      call text%append(body // new_line('a'))
    end do
    descriptor = posix_open(work%path // c_null_char, append)
    if (descriptor < 0) then
      failure = work%path // ': cannot be written: ' // system_reason()
      return
    end if
    call write_bytes(descriptor, text%text(), failure)
    if (allocated(failure)) failure = work%path // ': cannot be written: ' // failure
    status = posix_fsync(descriptor)
    status = posix_close(descriptor)
    if (.not. allocated(failure)) call note_progress(work, first + size(records) - 1)
  end subroutine keep_records

  ! Sets the message about kept work that an interruption prints.
  subroutine note_progress(work, done)
    type(kept_work), intent(in) :: work
    integer, intent(in) :: done

    call note_kept('; ' // decimal_text(done) // ' ' // work%piece // 's are saved in ' // &
                   printable_text(work%path) // ', the same command continues from there')
  end subroutine note_progress

  !> Reads all complete records; on exit `used` is the position of their last byte.
  subroutine take_records(text, piece, most, used, records)
    character(len=*), intent(in) :: text, piece
    integer, intent(in) :: most
    integer, intent(inout) :: used
    type(word_record), allocatable, intent(inout) :: records(:)
    type(word_record), allocatable :: found(:), larger(:)
    integer :: length, first, line_end, done

    allocate (found(64))
    done = 0
    do while (done < most)
      line_end = index(text(used + 1:), new_line('a'))
      if (line_end == 0) exit
      first = used + line_end + 1
      length = word_digits * word_count_of(text(used + 1:used + line_end - 1))
      if (length < 0 .or. length > len(text) - first) exit
      if (text(first + length:first + length) /= new_line('a')) exit
      if (text(used + 1:used + line_end) /= &
          heading_of(piece, done + 1, text(first:first + length - 1))) exit
      if (done == size(found)) then
        allocate (larger(2 * done))
        larger(:done) = found
        call move_alloc(larger, found)
      end if
      done = done + 1
      allocate (found(done)%words(length / word_digits))
      call from_hexadecimal(text(first:first + length - 1), found(done)%words)
      used = first + length
    end do
    deallocate (records)
    allocate (records(done))
    records = found(:done)
  end subroutine take_records

  !> Number of words in the line before a record; -1 when it is no such line.
  pure integer function word_count_of(line) result(number)
    character(len=*), intent(in) :: line
    integer :: first, last, status

    number = -1
    first = index(line, ', words ') + len(', words ')
    last = index(line, ', checksum ') - 1
    if (first <= len(', words ') .or. last < first .or. last > first + 7) return
    read (line(first:last), '(i8)', iostat=status) number
    if (status /= 0) number = -1
  end function word_count_of

  !> The line before the words of a record.
  pure function heading_of(piece, record, body) result(line)
    character(len=*), intent(in) :: piece, body
    integer, intent(in) :: record
    character(len=:), allocatable :: line
    character(len=60) :: text

    write (text, '(" ", i0, ", words ", i0, ", checksum ", a8)') record, len(body) / word_digits, &
      checksum(body)
    line = piece // trim(text) // new_line('a')
  end function heading_of

  pure function hexadecimal_text(words) result(text)
    integer(int64), intent(in) :: words(:)
    character(len=word_digits * size(words)) :: text
    integer :: i

    do i = 1, size(words)
      write (text(word_digits * (i - 1) + 1:word_digits * i), '(z16.16)') words(i)
    end do
  end function hexadecimal_text

  pure subroutine from_hexadecimal(text, words)
    character(len=*), intent(in) :: text
    integer(int64), intent(out) :: words(:)
    integer :: i

    do i = 1, size(words)
      read (text(word_digits * (i - 1) + 1:word_digits * i), '(z16)') words(i)
    end do
  end subroutine from_hexadecimal

  !> FNV-1a of 32 bits (Fowler, Noll, Vo), as 8 hexadecimal digits.
  pure function checksum(text) result(word)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=8) :: word
    integer(int64), parameter :: prime = 16777619_int64, low_32 = int(z'FFFFFFFF', int64)
    integer(int64) :: state
    integer :: i

    state = 2166136261_int64
    do i = 1, len(text)
      state = iand(ieor(state, int(iachar(text(i:i)), int64)) * prime, low_32)
    end do
    write (word, '(z8.8)') state
  end function checksum

end module asperity_kept_records
